"""Whole scenes from YAML to log, against what is known of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from google.protobuf.descriptor_pb2 import FileDescriptorSet
from google.protobuf.descriptor_pool import DescriptorPool
from google.protobuf.message_factory import GetMessageClass
from mcap.reader import make_reader

from components.tether.catenary.hang import hang
from pipeline.log.reader import open_log
from pipeline.run import Options, run_scenario
from pipeline.scenario import load_scenario, load_scenario_text
from pipeline.wiring import build_graph

SCENARIOS = Path(__file__).parents[2] / "scenarios"


def run(scenario, path):
    result = run_scenario(scenario, build_graph(scenario), path, Options(), lambda _: None)
    return result, open_log(path)


@pytest.fixture(scope="module")
def pool(tmp_path_factory):
    path = tmp_path_factory.mktemp("pool") / "pool.mcap"
    return run(load_scenario(SCENARIOS / "pool_chain.yaml", duration="30 s"), path)[1]


def test_chain_at_rest_is_the_catenary(pool):
    """Two formulations: the dynamic line at t0 against the closed form; 50 segments differ from it by 1/50^2."""
    force, nodes = pool.port("tether", "force_b")[0], pool.port("tether", "nodes")[0]
    wet = (0.1054 - 1000 * 1.3427e-5) * 9.80665
    line = hang(3.5, wet, float(nodes[-1, 0] - nodes[0, 0]), 0.0, 450e3)
    assert np.hypot(force[0], force[1]) == pytest.approx(line.H_N, rel=1e-3)
    assert force[2] == pytest.approx(line.V_b_N, rel=1e-3)
    assert nodes[:, 2].max() - nodes[0, 2] == pytest.approx(line.sag_m, rel=1e-3)


def test_every_step_converged(pool):
    assert (pool.port("tether", "converged") == 1).all()


def test_ends_follow_their_wires(pool):
    nodes = pool.port("tether", "nodes")
    assert (nodes[:, -1] == pool.port("hand", "motion.position")).all()
    assert (nodes[:, 0] == pool.port("wall", "motion.position")).all()


def test_a_stranger_reads_the_same_numbers(pool):
    """With the mcap reader and protobuf alone."""
    with open(pool.path, "rb") as file:
        found = []
        for schema, channel, message in make_reader(file).iter_messages(topics=["tether"]):
            types = DescriptorPool()
            for one in FileDescriptorSet.FromString(schema.data).file:
                types.Add(one)
            assert channel.message_encoding == "protobuf"
            decoded = GetMessageClass(types.FindMessageTypeByName(schema.name)).FromString(message.data)
            found.append((message.log_time, decoded.force_b[2], *decoded.nodes[-3:]))
            if len(found) == 200:
                break
    expected = np.column_stack([pool.port("tether", "force_b")[:, 2], pool.port("tether", "nodes")[:, -1]])
    assert [t for t, *_ in found] == pool.times("tether")[:200].tolist()
    assert np.array([values for _, *values in found]).tobytes() == expected[:200].tobytes()


def test_hand_by_a_table_from_csv(tmp_path):
    (tmp_path / "hand.csv").write_text("time_s,north_m,east_m,down_m\n0,0,0,0\n1,0.2,0,0\n2,0.2,0.3,0\n3,0,0,0.1\n")
    text = """
duration: 3 s
step: 10 ms
components:
  hand:
    model: motion.hand
    parameters: {centre: [1 m, 0 m, 0 m], table: {csv: hand.csv}}
"""
    result, log = run(load_scenario_text(text, "test.yaml", tmp_path), tmp_path / "hand.mcap")
    position = log.port("hand", "motion.position")
    assert np.abs(position[::100] - [[1, 0, 0], [1.2, 0, 0], [1.2, 0.3, 0], [1, 0, 0.1]]).max() < 1e-12
    (tmp_path / "hand.csv").unlink()
    again = load_scenario_text(log.attachment("scenario.yaml").decode(), "log", tmp_path)
    assert run(again, tmp_path / "again.mcap")[0].digest == result.digest


def test_body_on_a_bond_hangs_and_swings(tmp_path):
    """In balance until it is pushed; then the period of a stiff pendulum, which the chain's drag hardly changes."""
    result, log = run(load_scenario(SCENARIOS / "bond_mass.yaml"), tmp_path / "bond.mcap")
    position, t = log.port("ball", "hook.position"), log.times("ball") * 1e-9
    assert np.abs(position[t < 1.0] - position[0]).max() < 1e-6
    bond = result.bonds["hook"]
    assert bond["unconverged"] == 0
    assert abs(bond["residual_J"]) < 1e-5 * bond["throughput_J"]
    swing = position[t > 10.0, 0]
    down = np.flatnonzero((swing[:-1] > 0) & (swing[1:] <= 0))
    period = np.diff(down).mean() * 0.01
    assert period == pytest.approx(_pendulum_period(), rel=0.01)


def test_sensors_of_a_drifting_vessel_see_it(tmp_path):
    """Errors against the truth in the log: within four stated deviations; faults where events set them."""
    log = run(load_scenario(SCENARIOS / "vessel_drift.yaml"), tmp_path / "drift.mcap")[1]
    truth, t = log.port("vessel", "position"), log.times("gnss") * 1e-9
    assert np.hypot(*truth[-1, :2]) > 20.0
    attitude = log.port("vessel", "attitude")
    heading = log.port("gyro", "heading") - attitude[:, 2]
    assert np.abs(heading).max() < np.radians(4 * 0.05 + 4 * 0.3)
    position, valid = log.port("gnss", "position"), log.port("gnss", "valid") == 1.0
    antenna = truth[::10, :2] + np.stack([_turned(a, (5.0, 1.0, -22.0)) for a in attitude[::10]])
    error = np.zeros(len(t))
    error[1:] = np.abs(position[1:, :2] - antenna[:-1]).max(axis=1)  # it comes a sample late
    calm = valid & (t < 170.0)
    assert calm.sum() > 100
    assert error[calm].max() < 4 * 0.1 + 4 * 0.3
    assert not valid[(t > 151.5) & (t < 170.0)].any()
    assert np.ptp(position[(t > 172.0) & (t < 181.0)], axis=0).max() == 0.0
    assert error[t == 182.0][0] > 55.0
    assert np.abs(log.port("thrusters", "thrust")[-1, 1]) < 1.0  # the one that stopped


def _turned(attitude, arm):
    """North and east of a body vector, by rotations about z, y and x (Fossen 2011, eq. 2.18)."""
    (cr, cp, cy), (sr, sp, sy) = np.cos(attitude), np.sin(attitude)
    x, y, z = arm
    across, below = cr * y - sr * z, sr * y + cr * z
    ahead = cp * x + sp * below
    return np.array([cy * ahead - sy * across, sy * ahead + cy * across])


def test_tether_ties_a_ship_and_an_rov(tmp_path):
    """Both ends on bonds with bodies that turn: every step within the bonds' tolerances, ends where the hooks are."""
    result, log = run(load_scenario(SCENARIOS / "rov_dive.yaml"), tmp_path / "dive.mcap")
    for bond in result.bonds.values():
        assert bond["unconverged"] == 0
        assert abs(bond["residual_J"]) < 1e-5 * bond["throughput_J"]
    nodes = log.port("tether", "nodes")
    assert np.array_equal(nodes[:, 0], log.port("ship", "hook_a.position"))
    assert np.array_equal(nodes[:, -1], log.port("rov", "hook.position"))
    assert np.abs(log.port("rov", "position")[-1] - [65.0, 44.0, 62.0]).max() < 1.0  # it went where it was sent


def _pendulum_period() -> float:
    """A stiff pendulum: body 2 kg under 15 N, damped by 2 N s/m, on 2 m of chain with its added mass across."""
    chain, length = 0.1054 + 1000 * 1.3427e-5, 2.0
    inertia = 2.0 * length**2 + chain * length**3 / 3
    weight = 15.0 * length + (0.1054 - 1000 * 1.3427e-5) * 9.80665 * length**2 / 2
    decay = 2.0 * length**2 / (2 * inertia)
    return 2 * np.pi / np.sqrt(weight / inertia - decay**2)
