% GNU Octave 7.3 made the .mat files beside this: octave-cli octave.m
frequency = (1:5)' * 2.5;
[k, i, j] = ndgrid(1:5, 1:4, 1:4);
H = 1e-9 * (k + 10 * i + 100 * j) + 1e-12i * (i + j);
labels = ["x1"; "y1"; "x2"; "y2"];
unit = "mm/N";
save("-v6", "octave_v6.mat", "frequency", "H", "labels", "unit");
save("-v7", "octave_v7.mat", "frequency", "H", "labels", "unit");
M = [2, 0.5; 0.5, 3];
C = [10, -1; -1, 20];
K = [1e6, -2e5; -2e5, 3e6];
B = [1, 0.1; 0.2, 1];
labels = ["x1"; "y1"];
notes = "written by Octave";
% -v6 with four letters is a file that Octave 7.3 itself cannot read: it counts them wrong
save("-v7", "octave_foundation.mat", "M", "C", "K", "B", "labels", "notes");
