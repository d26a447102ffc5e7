"""Arrow against pyarrow alone, writing the same columns of the same million samples to a new file.

    python -m pytest -o addopts= tests/benchmarks/test_formats_arrow.py

Tables are asserted equal first; ratios are of medians of repeats taken in turns.  pyarrow is given what is
there already, and of dated samples the nanoseconds too: the time that those take is ours.
"""

import statistics
import time

import numpy as np
import pyarrow as pa
import pytest
from astropy.time import Time

from attitude import Ephemeris, RigidBody, TorqueFreeMotion
from attitude.formats import columnar
from attitude.samples.chunks import CHUNK_INSTANTS, Samples
from attitude.times.instants import as_instants

COUNT = 1_000_000
REPEATS = 21
WRITERS = {"arrow": pa.ipc.new_file, "arrows": pa.ipc.new_stream}
READERS = {"arrow": pa.ipc.open_file, "arrows": pa.ipc.open_stream}
EPOCHS = {"undated": None, "dated": Time("2020-01-01T00:00:00", scale="utc")}


def sampled(epoch):
    motion = TorqueFreeMotion(RigidBody((1.0, 2.0, 3.0)), (1, 0, 0, 0), (0.3, 0.4, 0.5), epoch, order="wxyz")
    return motion.ephemeris(as_instants(np.linspace(0.0, 1e6, COUNT), epoch), rate=True)


def in_turns(works, path):
    """Median seconds of each, each time to a new file."""
    runs = []
    for _ in range(REPEATS + 1):
        runs.append([])
        for work in works:
            begun = time.perf_counter()
            work(path)
            runs[-1].append(time.perf_counter() - begun)
            path.unlink()
    return [statistics.median(run[i] for run in runs[1:]) for i in range(len(works))]


@pytest.mark.parametrize("epoch", EPOCHS.values(), ids=EPOCHS)
@pytest.mark.parametrize("format", WRITERS)
def test_arrow_against_pyarrow_alone(benchmark, format, epoch, tmp_path):
    ephemeris, path = sampled(epoch), tmp_path / f"a.{format}"
    names = columnar.names(Samples.of(ephemeris))
    columns = columnar.columns(ephemeris, names)

    def ours(to):
        ephemeris.write(to, format)

    def theirs(to):
        table = pa.table([pa.array(columns[name]) for name in names], names)
        with WRITERS[format](str(to), table.schema) as writer:
            writer.write_table(table, max_chunksize=CHUNK_INSTANTS)

    tables = []
    for write in (ours, theirs):
        write(path)
        tables.append(READERS[format](path.read_bytes()).read_all())
        path.unlink()
    assert tables[0].column_names == tables[1].column_names
    assert all(mine.equals(other) for mine, other in zip(*(each.columns for each in tables), strict=True))
    mine, alone = in_turns((ours, theirs), path)
    benchmark.pedantic(lambda: ours(path), rounds=3)
    benchmark.extra_info.update(figure=mine / alone, reach="<= 1.5 x pyarrow alone")
    print(f"\n    {mine / alone:.3g} (to reach: <= 1.5 x pyarrow alone; {1e3 * mine:.1f} ms)")
    assert mine <= 1.5 * alone


@pytest.mark.parametrize("format", WRITERS)
def test_arrow_is_read_as_it_was_written(benchmark, format, tmp_path):
    """No figure to reach: what a million attitudes take to be read, checked, and stood beside each other."""
    written, path = sampled(None), tmp_path / f"a.{format}"
    written.write(path)
    back = benchmark.pedantic(lambda: Ephemeris.read(path), rounds=5, warmup_rounds=1)
    assert np.array_equal(back.quaternion("wxyz"), written.quaternion("wxyz"))
