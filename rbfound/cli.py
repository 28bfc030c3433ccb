"""The commands of a terminal: `rbfound check`, `rbfound identify`, `rbfound campbell`.

Exit codes: 0 all is well, 1 the report warns of something, 2 the input is wrong (the message names file and line).
"""

import argparse
import sys
from collections.abc import Sequence
from textwrap import fill

import numpy as np

from rbfound.campbell_diagram import campbell
from rbfound.files import explained, load_frf, load_machine, save_foundation, text_replaced
from rbfound.foundation import Foundation
from rbfound.frf import FRF
from rbfound.identification import fit_modes
from rbfound.measurement import Report, check
from rbfound.tables import table
from rbfound.units import rpm

FILES = """FILES is a folder with a text file for each pair of seats (x1_from_y1.txt, ...), an index with the heading
'file, response, force', a table (.csv), a Universal File (.uff, .unv), or .npz or .mat with frequency, H,
labels, unit."""

EXAMPLES = """examples:
  rbfound check measured/ --unit g                     accelerances in g, per newton
  rbfound check export/ --columns "frequency [Hz], amplitude [mm], phase [deg]" --force 100
  rbfound identify measured/ --unit g --band 20 600 -o foundation.json --report report.html
  rbfound campbell machine.toml                        the machine, with that foundation under it

exit codes: 0 all is well; 1 the FRFs were read, but there is something to warn of; 2 the input is wrong
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; the words of the command line unless given. Returns the exit code."""
    options = _parser().parse_args(arguments)
    try:
        code: int = options.run(options)
    except ValueError as error:
        sys.stderr.write(f"rbfound: {error}\n")
        return 2
    except OSError as error:
        sys.stderr.write(f"rbfound: {error.filename or ''}: {error.strerror}\n")
        return 2
    except KeyboardInterrupt:
        sys.stderr.write("rbfound: interrupted; no file is half written\n")
        return 130
    return code


def _parser() -> argparse.ArgumentParser:
    raw = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(
        prog="rbfound",
        description="From a foundation's measured FRFs to the Campbell diagram of the machine on it.",
        epilog=EXAMPLES,
        formatter_class=raw,
    )
    commands = parser.add_subparsers(required=True, metavar="COMMAND")
    look = commands.add_parser(
        "check", help="say what a set of FRFs is worth", description="Say what a set of FRFs is worth.\n\n" + FILES,
        epilog=EXAMPLES, formatter_class=raw,
    )  # fmt: skip
    find = commands.add_parser(
        "identify", help="make a foundation of a set of FRFs",
        description="Make a foundation of a set of FRFs: all modes of the band, and what lies outside it.\n\n" + FILES,
        epilog=EXAMPLES, formatter_class=raw,
    )  # fmt: skip
    turn = commands.add_parser(
        "campbell", help="natural frequencies and critical speeds of a machine",
        description="Natural frequencies and critical speeds of the machine that a TOML file describes.",
        epilog=sys.modules[load_machine.__module__].__doc__, formatter_class=raw,
    )  # fmt: skip
    for command in (look, find):
        command.add_argument("files", metavar="FILES", help="see above")
        command.add_argument(
            "--unit", help="of the responses, where no file says it: m, mm, m/s2, g, mm/N, dB re m/N ..."
        )
        command.add_argument("--quantity", help="a check of the unit; stiffness, impedance, apparent mass: invert")
        command.add_argument(
            "--force", type=float, default=1.0, metavar="N", help="force of the responses, 1 N unless given"
        )
        command.add_argument("--columns", help="what the columns are, where no heading says it")
        command.add_argument("--pattern", help="names of the files: 'H_{response}_{force}.csv' or 'FRF{number}.txt'")
        command.add_argument("--seats", metavar="MAP", help="which points of the file are seats: '12+Z = y1, 7-X = x1'")
        command.add_argument("--conjugate", action="store_true", help="the phases are those of exp(-i omega t)")
        command.add_argument(
            "--delay",
            type=float,
            default=0.0,
            metavar="S",
            help="the motion was recorded so much later than the force",
        )
        command.add_argument("--fill", action="store_true", help="take a missing H_ij from H_ji")
        command.add_argument("--band", type=float, nargs=2, metavar=("LOW", "HIGH"), help="[Hz]; else all lines")
    look.add_argument("--explain", action="store_true", help="say first what was understood of each file")
    find.add_argument("-o", "--output", required=True, metavar="FILE", help=".json, .npz or .mat")
    find.add_argument("--report", metavar="PAGE", help="write a page (.html) with figures that a colleague can open")
    find.add_argument("--modes", type=int, help="how many modes the band holds, if you know")
    turn.add_argument("machine", metavar="MACHINE", help="a .toml file, see below")
    turn.add_argument("--count", type=int, default=8, help="how many natural frequencies, 8 unless given")
    turn.add_argument("--steps", type=int, default=41, help="at how many speeds, 41 unless given")
    look.set_defaults(run=_check)
    find.set_defaults(run=_identify)
    turn.set_defaults(run=_campbell)
    return parser


SAID = ("unit", "quantity", "force", "columns", "pattern", "fill", "seats", "conjugate", "delay")


def _loaded(options: argparse.Namespace) -> FRF:
    frf = load_frf(options.files, **{name: getattr(options, name) for name in SAID})
    return frf if options.band is None else frf.between(*options.band)


def _check(options: argparse.Namespace) -> int:
    if options.explain:
        sys.stdout.write(explained(options.files, **{name: getattr(options, name) for name in SAID}) + "\n\n")
    report = check(_loaded(options))
    sys.stdout.write(f"{report}\n")
    return 1 if report.warnings else 0


def _identify(options: argparse.Namespace) -> int:
    frf = _loaded(options)
    report = check(frf)
    sys.stdout.write(f"{report}\n\n")
    sys.stderr.write(f"rbfound: fitting modes to {len(frf.frequency)} lines ...\n")
    foundation = fit_modes(frf, modes=options.modes).foundation()
    save_foundation(foundation, options.output)
    sys.stdout.write(f"{foundation}\nwritten: {options.output}\n")
    if options.report:
        text_replaced(options.report, _page(frf, report, foundation))
        sys.stdout.write(f"written: {options.report}\n")
    return 1 if report.warnings or _warnings(foundation) else 0


def _warnings(foundation: Foundation | None) -> list[str]:
    """What a foundation's notes warn of; nothing on rigid ground."""
    return [note for note in (foundation.notes if foundation else ()) if note.startswith("Warning:")]


def _page(frf: FRF, report: Report, foundation: Foundation) -> str:
    try:
        # the one import that waits: matplotlib is an extra, and only a page needs it
        from rbfound.plots import page
    except ImportError as error:
        raise ValueError(f"--report needs matplotlib: pip install 'rbfound[plots]' ({error}).") from None
    return page(frf, report, foundation)


def _campbell(options: argparse.Namespace) -> int:
    if options.steps < 2 or options.count < 1:
        raise ValueError(
            f"--steps {options.steps} --count {options.count}: at least 2 speeds and 1 frequency are needed."
        )
    said = load_machine(options.machine)
    speeds = np.linspace(*said.speeds, options.steps)
    diagram = campbell(said.machine, speeds, options.count)
    shown = np.unique(np.linspace(0, len(speeds) - 1, 6).round().astype(int))
    columns: dict[str, object] = {"mode": list(range(1, diagram.frequency.shape[1] + 1))}
    for k in shown:
        columns[f"{rpm(speeds[k]):.0f} rev/min"] = diagram.frequency[k]
    sys.stdout.write("Natural frequencies [Hz] over speed\n")
    sys.stdout.write(table(columns) + "\n\n")
    critical = diagram.critical_speeds()
    if len(critical.frequency):
        sys.stdout.write(
            table({"critical speed [rev/min]": rpm(critical.speed), "damping [%]": 100 * critical.damping}) + "\n"
        )
    else:
        sys.stdout.write("No critical speed lies in this range.\n")
    unstable = np.flatnonzero(diagram.unstable())
    if len(unstable):
        sys.stdout.write(f"Warning: unstable in this range: mode {', '.join(str(k + 1) for k in unstable)}.\n")
    warnings = _warnings(said.machine.foundation)
    if warnings:
        lines = "\n".join(fill(note, 92) for note in warnings)
        sys.stdout.write(f"The foundation came with warnings:\n{lines}\n")
    return 1 if len(unstable) or warnings else 0


if __name__ == "__main__":
    sys.exit(main())
