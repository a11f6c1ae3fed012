"""Wind, sea and current against their spectra's integrals, standards' tables and processes' theory."""

from __future__ import annotations

import ctypes
from math import pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.signal import welch

from components.compiled import bind
from components.environment.sea.component import COMPONENT as SEA
from components.environment.sea.spectrum import jonswap, peakedness
from components.environment.stream.component import COMPONENT as STREAM
from components.environment.wind import spectra
from components.environment.wind.component import COMPONENT as WIND

FUNCTION = ctypes.CFUNCTYPE(ctypes.c_int64, ctypes.c_int64, ctypes.c_int64, *[ctypes.c_void_p] * 5)


class Instance:
    """A component outside a conductor; y and w are filled with NaN before every call."""

    def __init__(self, component, h, seed=1, **parameters):
        self.component, self.parameters = component, component.parameters(**parameters)
        self.p, self.h, self.t, self.seed = component.pack(self.parameters, seed), round(h * 1e9), 0, seed
        self.u, self.x, self.y, self.w = (np.zeros(int(n)) for n in self.p[1:5])
        entries = bind(component)
        self._init, self._step = FUNCTION(entries.init), FUNCTION(entries.step)
        self._call(self._init)

    def _call(self, function):
        self.y[:] = self.w[:] = np.nan
        vectors = (self.p, self.u, self.x, self.y, self.w)
        assert function(self.t, self.h, *[vector.ctypes.data for vector in vectors]) == 0
        assert np.isfinite(self.y).all()

    def step(self):
        self.t += self.h
        self._call(self._step)

    def set(self, **more):
        self.parameters = self.parameters.model_copy(update=more)
        self.p = self.component.pack(self.parameters, self.seed)

    def record(self, name, steps):
        span = self.span(name)
        rows = np.empty((steps, span.stop - span.start))
        for row in rows:
            self.step()
            row[:] = self.y[span]
        return rows

    def span(self, name):
        k = 0
        for port in self.component.outputs(self.parameters):
            if port.name == name:
                return slice(k, k + port.size)
            k += port.size
        raise KeyError(name)

    def __getitem__(self, name):
        return self.y[self.span(name)].copy()


STORM = {"height": 4.0, "period": 9.0, "direction": 0.5}


@pytest.mark.parametrize("gamma", [1.0, 3.3, 5.0])
def test_jonswap_integrates_to_the_height(gamma):
    """m_0 = H_s^2 / 16; DNV-RP-C205 gives the same shape with 1 - 0.287 ln(gamma), a fit that is within 1.5 %."""
    area = quad(lambda w: jonswap(np.array([w]), 4.0, 9.0, gamma)[0], 0.1, 20.0, limit=400, points=[2 * pi / 9])[0]
    assert area == pytest.approx(1.0, rel=1e-4)
    peak = 2 * pi / 9
    published = (1 - 0.287 * np.log(gamma)) * 5 / 16 * 16 * peak**4 * peak**-5 * np.exp(-1.25) * gamma
    assert jonswap(np.array([peak]), 4.0, 9.0, gamma)[0] == pytest.approx(published, rel=0.015)


def test_peakedness_is_dnvs():
    """DNV-RP-C205, 3.5.5.5: 5 for T_p / sqrt(H_s) <= 3.6, exp(5.75 - 1.15 T_p / sqrt(H_s)) up to 5, then 1."""
    assert peakedness(9.0, 9.0) == 5.0
    assert peakedness(4.0, 9.0) == pytest.approx(np.exp(5.75 - 1.15 * 4.5))
    assert peakedness(1.0, 9.0) == 1.0


def test_components_make_up_the_variance():
    """sum a^2 / 2 = H_s^2 / 16 by construction, and omega^2 = g k tanh(k d) for each (Airy)."""
    sea = Instance(SEA, 0.5, **STORM, water_depth=30.0)
    assert (sea["waves.amplitude"] ** 2).sum() / 2 == pytest.approx(1.0, rel=1e-12)
    k, omega = sea["waves.wave_number"], sea["waves.frequency"]
    assert 9.80665 * k * np.tanh(k * 30.0) == pytest.approx(omega**2, rel=1e-12)
    assert sea["waves.direction"] == pytest.approx(0.5 + pi)


def test_surface_has_the_variance_and_the_spectrum():
    """Over 4 hours. Variance: by sum a_i^4 / (8 n_i), n_i independent values of each line, under 2 %; spectrum by
    Welch in bands of energy: each has 100 segments or more, 10 % of standard deviation; 4 sigma with 200 lines."""
    sea = Instance(SEA, 0.5, **STORM, components=200, gamma=3.3)
    eta = sea.record("elevation", 4 * 7200)[:, 0]
    assert eta.var() == pytest.approx(1.0, rel=0.05)
    assert abs(eta.mean()) < 0.02
    f, s = welch(eta, fs=2.0, nperseg=512)
    omega = 2 * pi * f
    for low, high in [(0.55, 0.66), (0.66, 0.75), (0.75, 0.95), (0.95, 1.4), (1.4, 2.6)]:
        inside = (omega >= low) & (omega < high)
        expected = quad(lambda w: jonswap(np.array([w]), 4.0, 9.0, 3.3)[0], low, high)[0]
        width = inside.sum() * (f[1] - f[0]) * 2 * pi / (high - low)  # the band that the bins do cover
        assert s[inside].sum() * (f[1] - f[0]) / width == pytest.approx(expected, rel=0.2), (low, high)


def test_spreading_has_its_law_and_seeds_differ():
    """cos^n: variance of the angle off the mean, by quadrature; 1000 draws, 4 standard errors of a variance, 18 %."""
    sea = Instance(SEA, 0.5, **STORM, components=1000, spread=4.0)
    off = sea["waves.direction"] - 0.5 - pi
    density = lambda a: np.cos(a) ** 4  # noqa: E731
    variance = quad(lambda a: a * a * density(a), -pi / 2, pi / 2)[0] / quad(density, -pi / 2, pi / 2)[0]
    assert off.var() == pytest.approx(variance, rel=0.18)
    assert abs(off.mean()) < 4 * sqrt(variance / 1000)
    assert abs(off).max() <= pi / 2
    other = Instance(SEA, 0.5, seed=2, **STORM, components=1000, spread=4.0)
    assert not (other["waves.phase"] == sea["waves.phase"]).any()
    again = Instance(SEA, 0.5, **STORM, components=1000, spread=4.0)
    assert again.y.tobytes() == sea.y.tobytes()


def test_a_calm_sea_is_flat():
    sea = Instance(SEA, 0.5, height=0.0, period=8.0, direction=0.0)
    sea.step()
    assert sea["elevation"][0] == 0.0


@pytest.mark.parametrize(("speed", "height"), [(10.0, 10.0), (20.0, 10.0), (20.0, 50.0)])
def test_npd_gusts_have_the_standards_intensity(speed, height):
    """ISO 19901-1: the integral of S up to 0.5 Hz is the square of I_u U by its own formula, to 15 %: both are fits."""
    variance = quad(lambda f: spectra.npd(np.array([f]), speed, height)[0], 1 / 3600, 0.5, limit=500)[0]
    told = spectra.intensity(speed, height) * spectra.mean_at(speed, height)
    assert sqrt(variance) == pytest.approx(told, rel=0.15)


def test_harris_and_davenport_integrate_to_the_surface_drag():
    """Closed forms of the integrals over all f: Davenport 6 kappa U^2; Harris 4 kappa U^2 2^(-1/3) B(1/2, 1/3) / 2."""
    from scipy.special import beta

    u, kappa = 20.0, spectra.SURFACE_DRAG
    whole = np.geomspace(1e-8, 1e4, 400_001)
    davenport = np.trapezoid(spectra.davenport(whole, u, 10.0), whole)
    harris = np.trapezoid(spectra.harris(whole, u, 10.0), whole)
    assert davenport == pytest.approx(6 * kappa * u**2, rel=2e-3)  # the tail above 1e4 Hz falls with f^(-2/3)
    assert harris == pytest.approx(4 * kappa * u**2 * 2 ** (-5 / 6) * 2**0.5 * beta(0.5, 1 / 3) / 2, rel=2e-3)


@pytest.mark.parametrize("gusts", ["npd", "harris", "davenport"])
def test_gusts_have_the_spectrums_variance(gusts):
    """Over 4 hours; the slowest harmonics have 24 periods in it: 4 standard errors are 10 %."""
    wind = Instance(WIND, 1.0, speed=15.0, direction=0.3, gusts=gusts)
    speed = wind.record("speed", 14400)[:, 0]
    integral = quad(lambda f: spectra.SPECTRA[gusts](np.array([f]), 15.0, 10.0)[0], 1 / 600, 0.5, limit=500)[0]
    assert speed.var() == pytest.approx(integral, rel=0.1)
    assert speed.mean() == pytest.approx(15.0, abs=0.15)


def test_wind_comes_from_its_direction_and_veers_and_rises():
    wind = Instance(WIND, 1.0, speed=10.0, direction=pi / 2, veer=0.01, rise=0.1, gusts="none")
    assert wind["velocity"] == pytest.approx([0.0, -10.0, 0.0], abs=1e-12)  # from the east, blowing west
    for _ in range(100):
        wind.step()
    assert wind["direction"] == pytest.approx(pi / 2 + 1.0)
    assert wind["speed"] == pytest.approx(20.0)
    wind.set(veer=0.0, rise=0.0)
    wind.step()
    assert wind["direction"] == pytest.approx(pi / 2 + 1.0)  # no jump where an event stops it


def test_wind_over_height_is_the_standards():
    """ISO 19901-1, eq. A.2, by hand: 20 m/s at 10 m is 24.2 m/s at 50 m within 0.1."""
    high = Instance(WIND, 1.0, speed=20.0, direction=0.0, height=50.0, gusts="none")
    assert high["speed"] == pytest.approx(20 * (1 + 0.0573 * 2 * np.log(5)), rel=1e-12)
    assert Instance(WIND, 1.0, speed=0.0, direction=0.0)["speed"] == 0.0


PROFILE = ({"depth": 0.0, "speed": 1.0, "direction": 0.0}, {"depth": 50.0, "speed": 0.5, "direction": pi / 2})


def test_current_is_linear_between_levels():
    stream = Instance(STREAM, 1.0, profile=PROFILE, depths=(0.0, 25.0, 80.0))
    assert stream["surface"] == pytest.approx([1.0, 0.0, 0.0])
    assert stream["velocity"].reshape(3, 3) == pytest.approx(np.array([[1, 0, 0], [0.5, 0.25, 0], [0, 0.5, 0]]))
    stream.set(factor=2.0, turn=pi / 2)
    stream.step()
    assert stream["surface"] == pytest.approx([0.0, 2.0, 0.0], abs=1e-12)


@pytest.mark.parametrize("h", [1.0, 60.0])
def test_variation_is_gauss_markov_for_any_step(h):
    """Standard deviation and correlation exp(-lag / T); 20 000 steps hold 2000 independent values of each."""
    stream = Instance(STREAM, h, variation=0.1, variation_time=10.0 if h == 1.0 else 600.0)
    v = stream.record("variation", 20_000)[:, :2]
    assert v.std() == pytest.approx(0.1, rel=0.08)
    lag = 10
    kept = np.exp(-1.0)
    assert (v[:-lag] * v[lag:]).mean() / v.var() == pytest.approx(kept, abs=0.08)
    assert abs(np.corrcoef(v.T)[0, 1]) < 0.1
