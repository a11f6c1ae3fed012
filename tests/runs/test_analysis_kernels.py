"""The analysis' kernels loaded without numba: the same bits as numba's own call, whatever happened to what was kept."""

from __future__ import annotations

from io import BytesIO

import numpy as np
import pytest
from elftools.elf.elffile import ELFFile

from pipeline.analysis import catenary_fit, compiled, continuity, plane

LIBM = {"asinh", "atan2", "cosh", "hypot", "sinh", "sqrt"}


@compiled.kernel
def twice(values, out):
    for i in range(len(values)):
        out[i] = 2.0 * values[i]


@compiled.kernel
def total(values):
    found = 0.0
    for i in range(len(values)):
        found += values[i]
    return found


@pytest.fixture
def fresh(tmp_path, monkeypatch):
    """An empty folder for the objects."""
    monkeypatch.setattr(compiled, "cache_folder", lambda: tmp_path)
    return tmp_path


def doubled() -> list[float]:
    out = np.empty(3)
    compiled.Kernel(twice.function)(np.arange(3.0), out)
    return out.tolist()


def test_object_is_kept_and_damage_is_mended(fresh):
    assert doubled() == [0.0, 2.0, 4.0]
    (kept,) = fresh.glob("*.object")
    whole = kept.read_bytes()
    for damaged in (b"", whole[:20], whole[:-1], whole[:-1] + bytes([whole[-1] ^ 1])):
        kept.write_bytes(damaged)
        assert doubled() == [0.0, 2.0, 4.0]
        assert compiled._read(kept) is not None


def test_what_an_object_cannot_take_goes_through_numba(fresh):
    assert total(np.arange(4.0)) == 6.0
    out = np.empty(6)
    compiled.Kernel(twice.function)(np.arange(6.0)[::2], out[::2])
    assert out[::2].tolist() == [0.0, 4.0, 8.0]
    assert list(fresh.glob("*.object")) == []


def test_fits_of_numba_and_of_the_objects_have_equal_bits(fresh):
    """The three kernels of `fast` on noisy markers, called both ways."""
    random = np.random.default_rng(0)
    k, m = 200, 12
    x = np.linspace(-1.0, 1.0, m)
    position = np.stack([np.broadcast_to(x, (k, m)), np.zeros((k, m)), -np.broadcast_to(np.cosh(x), (k, m))], axis=2)
    position = position + 0.01 * random.standard_normal(position.shape)
    valid, reach, often = random.random((k, m)) > 0.1, 0.3 * np.arange(m), np.zeros(m, np.int64)
    place, scratch = np.empty((2, m), np.int64)
    found = []
    for way in (lambda kernel: kernel, lambda kernel: kernel.dispatcher):
        order, counts = np.empty((k, m), np.int64), np.zeros((4, k), np.int64)
        way(compiled.Kernel(continuity._check_all.function))(
            position, valid, reach, often, place, scratch, order, *counts[:2]
        )
        numbers, points = np.full((k, plane.COLUMNS), np.nan), np.zeros((k, m, 2))
        way(compiled.Kernel(plane._fit_all.function))(
            position, order, np.empty((2 * m + 6, 3)), *counts[2:], numbers, points
        )
        status, curves = np.zeros(k, np.int64), np.full((k, 5), np.nan)
        n = np.where(counts[2] == plane.FITTED, counts[3], 0)
        way(compiled.Kernel(catenary_fit._fit_all.function))(points, n, np.empty((m, 5)), status, curves)
        found.append((order, counts, numbers, points, status, curves))
    assert np.isfinite(found[0][5]).all(axis=1).sum() > k / 2
    for one, other in zip(*found, strict=True):
        assert one.tobytes() == other.tobytes()
    assert len(list(fresh.glob("*.object"))) == 3
    for path in fresh.glob("*.object"):
        binary = path.read_bytes()[32:].partition(b"\0")[2]
        symbols = ELFFile(BytesIO(binary)).get_section_by_name(".symtab").iter_symbols()
        assert {s.name for s in symbols if s["st_shndx"] == "SHN_UNDEF" and s.name} <= LIBM
