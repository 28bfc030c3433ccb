"""Readers of what is exported for ANSYS and NASTRAN, as their manuals have it."""

import numpy as np

DEGREES = ("UX", "UY", "UZ", "ROTX", "ROTY", "ROTZ")


def read_ansys(text):
    """M, K, C over all (node, degree) that elements have, and the constraints, as ANSYS' manual has it."""
    options, reals, matrices, ties, fixed = {}, {}, {2: {}, 4: {}, 5: {}}, [], set()
    kind = real = 0
    for line in text.splitlines():
        command, *cells = line.split(",")
        if command == "ET":
            assert cells[1] == "MATRIX27"
        elif command == "KEYOPT":
            options[int(cells[0]), int(cells[1])] = int(cells[2])
        elif command == "R":
            last = reals[int(cells[0])] = [float(cell) for cell in cells[1:]]
        elif command == "RMORE":
            assert len(cells) <= 6
            last += [float(cell) for cell in cells]
        elif command == "TYPE":
            kind = int(cells[0])
        elif command == "REAL":
            real = int(cells[0])
        elif command == "D":
            fixed.add((int(cells[0]), cells[1]))
        elif command == "E":
            assert options[kind, 2] == 0  # symmetric: C1 to C78 are the upper triangle, row by row
            A = np.zeros((12, 12))
            A[np.triu_indices(12)] = reals[real]
            A = np.triu(A) + np.triu(A, 1).T
            where = [(int(cells[k // 6]), DEGREES[k % 6]) for k in range(12)]
            for i in range(12):
                for j in range(12):
                    total = matrices[options[kind, 3]]
                    total[where[i], where[j]] = total.get((where[i], where[j]), 0.0) + A[i, j]
        elif command == "CE":
            if cells[0] == "NEXT":
                ties.append([])
            assert float(cells[1]) == 0
            ties[-1] += [((int(n), d), float(c)) for n, d, c in zip(cells[2::3], cells[3::3], cells[4::3], strict=True)]
    return matrices, ties, fixed


def assembled(matrix, ties, free, seats):
    """The matrix over the free unknowns and B, from a reader's dictionaries."""
    place = {name: k for k, name in enumerate(free)}
    A = np.zeros((len(free), len(free)))
    for (i, j), value in matrix.items():
        if i in place and j in place:
            A[place[i], place[j]] = value
    B = np.zeros((len(seats), len(free)))
    for row, (seat, tie) in enumerate(zip(seats, ties, strict=True)):
        assert tie[0] == (seat, -1.0)
        for name, value in tie[1:]:
            B[row, place[name]] = value
    return A, B


def read_bulk(text):
    """Symmetric DMIG matrices, MPC equations and scalar points of a bulk data file in small and large fields."""
    cards, points = [], set()
    for line in text.splitlines():
        if line.startswith("$") or not line.strip():
            continue
        assert len(line) <= 72
        name, width = line[:8].strip(), 16 if "*" in line[:8] else 8
        fields = [line[k : k + width].strip() for k in range(8, 72, width)]
        if name == "*":
            cards[-1][1].extend(fields)
        else:
            cards.append((name, fields))
    matrices, ties = {}, []
    for name, fields in cards:
        if name == "SPOINT":
            last = int(fields[2]) if fields[1] == "THRU" else int(fields[0])
            points |= set(range(int(fields[0]), last + 1))
        elif name == "DMIG":
            assert fields[1:5] == ["0", "6", "2", "0"]  # a header: symmetric, real, double precision
            matrices[fields[0]] = {}
        elif name == "DMIG*":
            j = int(fields[1])
            for k in range(4, len(fields), 4):
                i, value = int(fields[k]), float(fields[k + 2])
                matrices[fields[0]][i, j] = matrices[fields[0]][j, i] = value
        elif name == "MPC*":
            terms = [fields[k : k + 3] for start in range(0, len(fields), 8) for k in (start + 1, start + 4)]
            ties.append([((int(p), int(c)), float(a)) for p, c, a in terms if p])
    return matrices, ties, points
