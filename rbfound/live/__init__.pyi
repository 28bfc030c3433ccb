"""What can be played with: in a notebook, and in the published page."""

from rbfound.live.bench import bench_of as bench_of
from rbfound.live.sketch import axis as axis, figure as figure, line as line
from rbfound.live.things import (
    OPENS as OPENS,
    THINGS as THINGS,
    Live as Live,
    front as front,
    opened as opened,
    packed as packed,
    script as script,
    sheet as sheet,
    start as start,
)
from rbfound.live.widgets import peak_picker as peak_picker
