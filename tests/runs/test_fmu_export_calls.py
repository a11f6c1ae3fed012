"""An exported FMU's C functions called by hand: state, instances, a program without Python, and every wrong call."""

from __future__ import annotations

import ctypes as c
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest

OK, WARNING, DISCARD, ERROR, FATAL = range(5)
DOUBLES = c.POINTER(c.c_double)
RING = "van_der_pol.yaml#a"
TETHER = "pool_chain.yaml#tether"
H = 0.02
LOGGER = c.CFUNCTYPE(None, c.c_void_p, c.c_char_p, c.c_int, c.c_char_p, c.c_char_p)


class Callbacks(c.Structure):
    _fields_ = [(name, LOGGER if name == "logger" else c.c_void_p) for name in ("logger", "a", "b", "d", "environment")]


class Library:
    """An FMI 2 FMU's shared library."""

    def __init__(self, path: Path, folder: Path):
        with zipfile.ZipFile(path) as archive:
            (name,) = [name for name in archive.namelist() if name.endswith(".so")]
            self.file = Path(archive.extract(name, folder / path.stem))
        self.about = fmpy.read_model_description(str(path))
        self.references = {v.name: v.valueReference for v in self.about.modelVariables}
        self.inputs = [v.valueReference for v in self.about.modelVariables if v.causality == "input"]
        self.outputs = [v.valueReference for v in self.about.modelVariables if v.causality == "output"]
        self.dll = c.CDLL(str(self.file))
        self.dll.fmi2Instantiate.restype = c.c_void_p
        self.said: list[str] = []
        self.callbacks = Callbacks(LOGGER(lambda _e, _n, _s, _c, message: self.said.append(message.decode())))

    def instance(self, guid: str = "") -> Instance | None:
        words = (b"one", 1, (guid or self.about.guid).encode(), b"", c.byref(self.callbacks), 0, 0)
        address = self.dll.fmi2Instantiate(*words)
        return Instance(self, c.c_void_p(address)) if address else None


class Instance:
    """One instance; calls give the status."""

    def __init__(self, library: Library, address: c.c_void_p):
        self.library, self.address = library, address

    def __call__(self, name: str, *arguments) -> int:
        return getattr(self.library.dll, f"fmi2{name}")(self.address, *arguments)

    def set(self, references, values) -> int:
        n = len(references)
        return self("SetReal", (c.c_uint * n)(*references), c.c_size_t(n), (c.c_double * n)(*values))

    def get(self, references, status: int = OK) -> np.ndarray:
        values = np.full(len(references), np.nan)
        words = (c.c_uint * len(references))(*references), c.c_size_t(len(references))
        assert self("GetReal", *words, values.ctypes.data_as(DOUBLES)) == status
        return values

    def begin(self, u=()) -> None:
        assert self.setup() == OK
        assert self("EnterInitializationMode") == OK
        assert self.set(self.library.inputs[: len(u)], u) == OK
        assert self("ExitInitializationMode") == OK

    def setup(self, start: float = 0.0, stop: float | None = None) -> int:
        return self(
            "SetupExperiment", 0, c.c_double(0), c.c_double(start), int(stop is not None), c.c_double(stop or 0)
        )

    def step(self, t: float, h: float) -> int:
        return self("DoStep", c.c_double(t), c.c_double(h), 1)

    def run(self, first: int, last: int, u) -> np.ndarray:
        """Outputs of steps first ... last - 1 with the inputs u(k)."""
        rows = []
        for k in range(first, last):
            assert self.set(self.library.inputs, u(k)) == OK
            assert self.step(k * H, H) == OK
            rows.append(self.get(self.library.outputs))
        return np.array(rows)


def hand(k: int) -> list[float]:
    """End a at rest, end b swinging: 18 inputs of a tether."""
    t = k * H
    fixed = [0.0, 0.0, 0.1, *[0.0] * 6]
    return [*fixed, 2.0 + 0.2 * np.sin(3.0 * t), 0.0, 0.5, 0.6 * np.cos(3.0 * t), 0, 0, -1.8 * np.sin(3.0 * t), 0, 0]


@pytest.fixture
def tether(fmu_of, tmp_path) -> Library:
    return Library(fmu_of(TETHER, 2), tmp_path)


@pytest.fixture
def ring(fmu_of, tmp_path) -> Library:
    return Library(fmu_of(RING, 2), tmp_path)


def test_restored_state_gives_the_same_bits(tether):
    one = tether.instance()
    one.begin(hand(0))
    one.run(0, 20, hand)
    state = c.c_void_p()
    assert one("GetFMUstate", c.byref(state)) == OK
    undisturbed = one.run(20, 40, hand)
    assert one("SetFMUstate", state) == OK
    assert one.run(20, 40, hand).tobytes() == undisturbed.tobytes()
    # The same memory is used again where the pointer is not null.
    before = state.value
    assert one("GetFMUstate", c.byref(state)) == OK
    assert state.value == before
    assert one("FreeFMUstate", c.byref(state)) == OK
    assert state.value is None


def test_serialized_state_goes_on_in_another_process_with_the_same_bits(tether, ring):
    one, other = tether.instance(), tether.instance()
    one.begin(hand(0))
    one.run(0, 20, hand)
    state, size, read = c.c_void_p(), c.c_size_t(), c.c_void_p()
    assert one("GetFMUstate", c.byref(state)) == OK
    assert one("SerializedFMUstateSize", state, c.byref(size)) == OK
    data = c.create_string_buffer(size.value)
    assert one("SerializeFMUstate", state, data, size) == OK
    undisturbed = one.run(20, 40, hand)
    assert other("DeSerializeFMUstate", data, size, c.byref(read)) == OK
    assert other("SetFMUstate", read) == OK  # of an instance that was never initialised
    assert other.run(20, 40, hand).tobytes() == undisturbed.tobytes()
    for place in (0, 45, 2000, size.value - 1):
        data[place] = bytes([data[place][0] ^ 1])
        assert other("DeSerializeFMUstate", data, size, c.byref(read)) == ERROR
        data[place] = bytes([data[place][0] ^ 1])
    assert other("DeSerializeFMUstate", data, c.c_size_t(size.value - 8), c.byref(read)) == ERROR
    assert ring.instance()("DeSerializeFMUstate", data, size, c.byref(read)) == ERROR


def test_instances_do_not_touch_each_other(tether):
    alone = tether.instance()
    alone.begin(hand(0))
    expected = alone.run(0, 20, hand)
    one, other = tether.instance(), tether.instance()
    one.begin(hand(0))
    other.begin(hand(50))
    rows = []
    for k in range(20):
        rows.append(one.run(k, k + 1, hand)[0])
        other.run(k, k + 1, lambda k: hand(2 * k + 50))
    assert np.array(rows).tobytes() == expected.tobytes()


def test_reset_starts_anew(tether):
    one = tether.instance()
    one.begin(hand(0))
    expected = one.run(0, 5, hand)
    assert one.set([tether.references["parameters.axial_stiffness"]], [1e5]) == OK
    assert one("Reset") == OK
    one.begin(hand(0))
    assert one.run(0, 5, hand).tobytes() == expected.tobytes()


def test_outputs_follow_the_inputs_in_initialization_mode(tether):
    """What masters do that solve for a consistent start: set, get, set, get."""
    one, other = tether.instance(), tether.instance()
    one.setup()
    assert one("EnterInitializationMode") == OK
    for k in (30, 10, 0):
        one.set(tether.inputs, hand(k))
        shape = one.get(tether.outputs)
    other.begin(hand(0))
    assert shape.tobytes() == other.get(tether.outputs).tobytes()


def test_outputs_that_init_cannot_give_yet_are_zero_with_a_warning(tether):
    """libcosim reads before it sets the first inputs; a failure counts when initialization mode is left."""
    one, other = tether.instance(), tether.instance()
    for instance in (one, other):
        instance.setup()
        assert instance("EnterInitializationMode") == OK
        assert instance.set(tether.inputs, [1e300 * value for value in hand(0)]) == OK
        assert not instance.get(tether.outputs, WARNING).any()
        assert not instance.get(tether.outputs, WARNING).any()
        assert "the outputs are zero until" in tether.said.pop()
        assert "tether.cable stopped at t = 0.000000000 s" in tether.said.pop()
        assert not tether.said  # told once, and init called once, however many variables are read one by one
    assert one("ExitInitializationMode") == ERROR
    assert "tether.cable stopped at t = 0.000000000 s" in tether.said.pop()
    refused(one, "after an error", one.step(0.0, H))
    assert other.set(tether.inputs, hand(0)) == OK
    assert other("ExitInitializationMode") == OK
    undisturbed = tether.instance()
    undisturbed.begin(hand(0))
    assert other.run(0, 5, hand).tobytes() == undisturbed.run(0, 5, hand).tobytes()


def test_program_without_python_has_the_same_bits(tether, tmp_path):
    """Compiled here, run with an empty environment: only libc and libm are there."""
    program = tmp_path / "program"
    source = Path(__file__).with_name("fmu_program.c")
    cc = shutil.which("cc")
    subprocess.run([cc, "-O1", source, "-o", program, "-ldl"], check=True, timeout=60)
    inputs = [
        word for pair in zip(tether.inputs, hand(7), strict=True) for word in (str(pair[0]), repr(float(pair[1])))
    ]
    words = [tether.file, tether.about.guid, str(len(tether.outputs)), str(tether.outputs[0]), "25", repr(H), *inputs]
    done = subprocess.run([program, *words], env={}, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    rows = [[int(word, 16) for word in line.split()] for line in done.stdout.splitlines()]
    one = tether.instance()
    one.begin(hand(7))
    expected = np.vstack([one.get(tether.outputs), one.run(0, 25, lambda _: hand(7))])
    assert np.array(rows, np.uint64).tobytes() == expected.tobytes()


def refused(one: Instance, said: str, status: int) -> None:
    """The call gave an error and said why."""
    assert status == ERROR
    assert said in one.library.said.pop()


def test_wrong_calls_are_errors_with_a_reason(ring):
    """Each one is refused and changes nothing: the run goes on to the bits of an undisturbed one."""
    undisturbed = ring.instance()
    undisturbed.begin([1.0])
    one, names = ring.instance(), ring.references
    refused(one, "before initialization mode; it may be called between steps only", one.step(0.0, H))
    refused(one, "start time inf s", one.setup(float("inf")))
    refused(one, "start time 1e+12 s", one.setup(1e12))
    refused(one, "before the start time", one.setup(2.0, 1.0))
    refused(one, "leaving initialization mode before", one("ExitInitializationMode"))
    one.begin([1.0])
    refused(one, "entering initialization mode between steps", one("EnterInitializationMode"))
    refused(one, "neighbour = nan", one.set(ring.inputs, [float("nan")]))
    refused(one, "neighbour = inf", one.set(ring.inputs, [float("inf")]))
    refused(one, "position cannot be set: the FMU computes it", one.set([names["position"]], [1.0]))
    refused(one, "fixed once initialization", one.set([names["parameters.position"]], [1.0]))
    refused(one, "parameters.mu = -1; expected it at least 0", one.set([names["parameters.mu"]], [-1.0]))
    refused(one, "value reference 99; there are 7 variables", one.set([99], [1.0]))
    # All of the values of a call are set or none: the first is fine here.
    refused(one, "neighbour = nan", one.set([names["parameters.mu"], names["neighbour"]], [9.0, float("nan")]))
    refused(one, "a null pointer", one("SetReal", None, c.c_size_t(2), None))
    refused(one, "is no variable of type Integer", one("GetInteger", (c.c_uint * 1)(0), c.c_size_t(1), (c.c_int * 1)()))
    for t, h in ((0.0, -H), (0.0, 0.0), (0.0, float("nan")), (0.0, 1e-10), (0.0, 1e300), (float("nan"), H), (1.0, H)):
        refused(one, "step", one.step(t, h))
    refused(one, "no state is given", one("SetFMUstate", None))
    refused(one, "no directional derivatives", one("GetDirectionalDerivative", *[None, c.c_size_t(1)] * 2, None, None))
    refused(one, "no step is under way", one("CancelStep"))
    assert one("SetReal", None, c.c_size_t(0), None) == OK
    assert ring.dll.fmi2DoStep(None, c.c_double(0), c.c_double(H), 1) == ERROR
    assert ring.dll.fmi2GetFMUstate(None, None) == ERROR
    ring.dll.fmi2FreeInstance(None)
    expected = undisturbed.run(0, 10, lambda k: [float(k)])
    assert one.run(0, 10, lambda k: [float(k)]).tobytes() == expected.tobytes()


def test_wrong_guid_and_model_exchange_are_refused(ring):
    assert ring.instance("{0}") is None
    assert "the guid is '{0}'" in ring.said.pop()
    assert not ring.dll.fmi2Instantiate(b"x", 0, ring.about.guid.encode(), b"", c.byref(ring.callbacks), 0, 0)
    assert "co-simulation only" in ring.said.pop()


def test_stop_time_is_kept(ring):
    one = ring.instance()
    one.setup(0.0, 3 * H)
    one("EnterInitializationMode")
    one("ExitInitializationMode")
    one.run(0, 3, lambda _: [0.0])
    refused(one, "beyond the stop time", one.step(3 * H, H))


def test_a_master_that_adds_its_steps_up_reaches_the_stop_time(ring):
    """Its last step ends 19 ns beyond, by rounding alone."""
    one, t = ring.instance(), 0.0
    one.setup(0.0, 10_000.0)
    one("EnterInitializationMode")
    one("ExitInitializationMode")
    for _ in range(100_000):
        assert one.step(t, 0.1) == OK, ring.said
        t += 0.1
    assert round(t * 1e9) == 10_000 * 10**9 + 19
    refused(one, "beyond the stop time", one.step(t, 0.1))


def test_times_are_the_nearest_nanosecond(ring):
    """A master that adds its steps up in doubles, 0.1 s by 0.1 s, gets the steps of one that multiplies."""
    adding, exact = ring.instance(), ring.instance()
    adding.begin([0.0])
    exact.begin([0.0])
    t = 0.0
    for k in range(2000):
        assert adding.step(t, 0.1) == OK
        assert exact.step(k * 100 / 1000, 0.1) == OK
        t += 0.1
    assert t != 200.0
    assert adding.get(ring.outputs).tobytes() == exact.get(ring.outputs).tobytes()
    time = c.c_double()
    assert adding("GetRealStatus", 2, c.byref(time)) == OK
    assert time.value == 200.0


def test_failing_step_says_the_status_text_and_can_be_taken_back(tether):
    """Ends pulled a light-second apart: the line's own status, and the saved state goes on."""
    one = tether.instance()
    one.begin(hand(0))
    state = c.c_void_p()
    one("GetFMUstate", c.byref(state))
    expected = one.run(0, 3, hand)
    one("SetFMUstate", state)
    one.set(tether.inputs, [1e300 * value for value in hand(1)])
    status = one.step(0.0, H)
    assert status == ERROR
    assert tether.said
    refused(one, "after an error", one.step(0.0, H))
    one("SetFMUstate", state)
    assert one.run(0, 3, hand).tobytes() == expected.tobytes()


def test_bonded_line_refuses_another_step_than_its_law_is_for(fmu_of, tmp_path):
    chain = Library(fmu_of("bond_mass.yaml#chain", 2), tmp_path)
    assert chain.about.coSimulation.canHandleVariableCommunicationStepSize is False
    one = chain.instance()
    one.begin([0.0, 0.0, 1.0, *[0.0] * 6, 0.0, 0.0, 3.0, *[0.0] * 6])
    refused(one, "its force laws need 0.010000000 s throughout", one.step(0.0, 0.02))
    assert one.step(0.0, 0.01) == OK


FUZZ = """
import random, sys, ctypes as c
from pathlib import Path
sys.path.insert(0, sys.argv[2])
from test_fmu_export_calls import DOUBLES, Library
import numpy as np
library = Library(Path(sys.argv[1]), Path(sys.argv[3]))
draw = random.Random(1)
odd = [0.0, -0.0, 1.0, -1.0, 1e300, -1e300, 5e-324, float("nan"), float("inf"), -float("inf"), 1e-9, 0.02]
number = lambda: draw.choice([draw.choice(odd), draw.gauss(0, 1), draw.gauss(0, 1e6)])
states = [c.c_void_p() for _ in range(3)]
count = 0
for _ in range(60):
    one, t = library.instance(), 0.0
    if draw.random() < 0.7:
        one.begin(draw.choice([[1.0], [0.0]]) if len(library.inputs) == 1 else [])
    for _ in range(60):
        n = draw.randrange(5)
        references = [draw.choice([draw.randrange(300), draw.randrange(2**32)]) for _ in range(n)]
        buffer = (c.c_double * 8)()
        size = c.c_size_t()
        action = draw.randrange(10)
        if action == 0: one.set(references, [number() for _ in references])
        elif action == 1: one("GetReal", (c.c_uint * n)(*references), c.c_size_t(n), buffer)
        elif action == 2: one("GetString", (c.c_uint * n)(*references), c.c_size_t(n), buffer)
        elif action in (3, 4): t += 0.02 * (one.step(draw.choice([t, number()]), draw.choice([0.02, number()])) == 0)
        elif action == 5: one("GetFMUstate", c.byref(draw.choice(states)))
        elif action == 6: one("SetFMUstate", draw.choice(states))
        elif action == 7: one(draw.choice(["EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset"]))
        elif action == 8: one.setup(number(), number())
        else:
            data = bytes(draw.randrange(256) for _ in range(64))
            one("DeSerializeFMUstate", data, c.c_size_t(64), c.byref(c.c_void_p()))
        count += 1
    library.dll.fmi2FreeInstance(one.address)
print(count)
"""


@pytest.mark.parametrize("text", [RING, TETHER])
def test_no_order_of_calls_crashes(text, fmu_of, tmp_path):
    """In a process of its own: the exit status is the proof."""
    words = [sys.executable, "-c", FUZZ, str(fmu_of(text, 2)), str(Path(__file__).parent), str(tmp_path)]
    done = subprocess.run(words, capture_output=True, text=True, timeout=120)
    assert (done.returncode, done.stdout) == (0, "3600\n"), done.stderr[-2000:]
