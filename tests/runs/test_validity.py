"""towline validity on a log, on tables and on other tools' files: the same numbers, or a refusal by name."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pandas
import pytest
from foxglove_schemas_protobuf.PosesInFrame_pb2 import PosesInFrame
from mcap.writer import Writer

from pipeline.cli import main
from pipeline.log.reader import open_log
from pipeline.log.schema import describe_message

ROOT = Path(__file__).parents[2]
POOL = str(ROOT / "scenarios" / "pool_chain.yaml")
# Drupt et al. 2022, Table II.
TABLE_II = {
    "alpha_deg": {"mean": 2.67, "min": 2.94e-5, "max": 29.1, "median": 1.70, "std": 3.08},
    "e_plane_mm": {"mean": 0.60, "min": 0.08, "max": 4.55, "median": 0.45, "std": 0.42},
    "e_catenary_mm": {"mean": 12.6, "min": 0.19, "max": 286.0, "median": 4.38, "std": 27.67},
}


@pytest.fixture(scope="module")
def log(tmp_path_factory) -> Path:
    """30 s of the chain: at rest, slow and fast in its plane, and slow across it; markers lost ten times as often."""
    path = tmp_path_factory.mktemp("validity") / "chain.mcap"
    words = ["run", POOL, "--until", "30s", "--set", "markers.visible_time=0.8 s", "--out", str(path), "--json"]
    assert main(words) == 0
    return path


@pytest.fixture(scope="module")
def markers(log) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times [s], positions (k, m, 3) in NED, visibility (k, m)."""
    with open_log(log) as one:
        return one.times("markers") * 1e-9, one.port("markers", "position"), one.port("markers", "valid") > 0.5


def judged(capsys, path, *words: str) -> dict:
    """The only cable that validity finds."""
    capsys.readouterr()
    assert main(["validity", str(path), *words, "--json"]) == 0
    cables = json.loads(capsys.readouterr().out)["cables"]
    assert len(cables) == 1
    return next(iter(cables.values()))


def refused(capsys, path, *words: str) -> str:
    """The message of a refusal."""
    capsys.readouterr()
    assert main(["validity", str(path), *words, "--json"]) == 1
    return json.loads(capsys.readouterr().out)["error"]


def indicators(cable: dict) -> np.ndarray:
    return np.array([list(cable[name].values()) for name in TABLE_II])


def test_alpha_and_e_plane_against_singular_values(capsys, log, markers):
    """The plane by NumPy's SVD frame by frame, N > 6 only; tolerance: roundings of SVD at 1e-16 of 3 m, over 0.1 mm."""
    _, position, valid = markers
    alpha, e_plane = [], []
    for points, seen in zip(position, valid, strict=True):
        if seen.sum() > 6:
            _, s, vt = np.linalg.svd(points[seen] - points[seen].mean(axis=0))
            alpha.append(np.degrees(np.arcsin(abs(vt[2, 2]))))
            e_plane.append(1e3 * s[2] / np.sqrt(seen.sum()))
    cable = judged(capsys, log)
    assert cable["frames"] == len(position)
    assert cable["frames_used"] == len(alpha)
    for name, values in (("alpha_deg", alpha), ("e_plane_mm", e_plane)):
        expected = [f(values) for f in (np.mean, np.min, np.max, np.median, np.std)]
        np.testing.assert_allclose(list(cable[name].values()), expected, rtol=1e-8, atol=1e-9)


def test_keys_and_published_figures(capsys, log):
    cable = judged(capsys, log)
    assert set(TABLE_II) | {"frames", "frames_used", "wall_s"} <= set(cable)
    assert all(list(cable[name]) == ["mean", "min", "max", "median", "std"] for name in TABLE_II)
    assert {name: cable["published"][name] for name in TABLE_II} == TABLE_II


def test_noise_is_told(capsys, log):
    """The tracker's own noise; on 12 or fewer markers a plane leaves sigma sqrt((N - 3) / N) of it, N > 6."""
    noise = judged(capsys, log)["noise"]
    assert noise["marker_mm"] == pytest.approx(0.4, rel=1e-12)
    assert 0.4 * np.sqrt(4 / 7) <= noise["e_plane_mm"] <= 0.4 * np.sqrt(9 / 12)
    assert 0.0 < noise["alpha_deg"] < 0.5
    assert judged(capsys, log, "--channel", "tether")["noise"] is None


def test_both_methods_agree(capsys, log):
    """Medians to 1 %: Nelder-Mead stops at its own tolerance, and not always at the least residual."""
    short = log.with_name("short.mcap")
    assert main(["run", POOL, "--until", "2s", "--out", str(short), "--overwrite", "--json"]) == 0
    fast, published = (judged(capsys, short, "--method", method) for method in ("fast", "nelder-mead"))
    assert published["method"] == "nelder-mead"
    for name in TABLE_II:
        assert fast[name]["median"] == pytest.approx(published[name]["median"], rel=0.01)


def test_tolerance_is_a_share_or_a_length(capsys, log):
    share, length = judged(capsys, log, "--tolerance", "2%"), judged(capsys, log, "--tolerance", "70 mm")
    assert share["tolerance_mm"] == pytest.approx(70.0, rel=1e-14)
    assert share["fails"] == length["fails"]
    assert all(70.0 < span["worst_mm"] <= share["e_catenary_mm"]["max"] for span in share["fails"])
    assert max(span["worst_mm"] for span in share["fails"]) == share["e_catenary_mm"]["max"]
    tighter = judged(capsys, log, "--tolerance", "0.02")
    failing = [sum(span["frames"] for span in cable["fails"]) for cable in (share, tighter)]
    assert 0 < failing[0] < failing[1] < share["frames_used"]


def test_the_line_itself_is_judged_by_its_nodes(capsys, log):
    cable = judged(capsys, log, "--channel", "tether")
    assert cable["frames_used"] == cable["frames"] == 1501
    assert cable["published"] is None


def test_exported_csv_gives_the_same_numbers(capsys, log, tmp_path):
    """Bit for bit: the export holds float64 exactly. The length is not in it, so the spans are of another tolerance."""
    assert main(["export", str(log), "--format", "csv", "-o", str(tmp_path), "--json"]) == 0
    cable = judged(capsys, tmp_path / "markers.csv")
    assert np.array_equal(indicators(cable), indicators(judged(capsys, log)))
    # 12 markers at 245 mm on a curve: their polyline is up to 1 % shorter than the 2.695 m of chain between them.
    assert cable["length_m"] == pytest.approx(2.695, rel=0.01)


def table_of(markers, names, axes, scale) -> pandas.DataFrame:
    """A motion-capture table, empty where lost: names(i, axis) of the columns; axes: the NED axis of each, signed."""
    _, position, valid = markers
    columns = {}
    for i in range(position.shape[1]):
        for axis, ned in zip("xyz", axes, strict=True):
            value = np.sign(ned) * position[:, i, abs(ned) - 1] * scale
            columns[names(i + 1, axis)] = np.where(valid[:, i], value, np.nan)
    return pandas.DataFrame(columns)


@pytest.mark.parametrize(
    ("time", "names", "axes", "scale"),
    [
        (("Time [ms]", 1e3), lambda i, axis: f"Marker {i} {axis.upper()} [mm]", (2, 1, -3), 1e3),
        (("timestamp_ns", 1e9), lambda i, axis: f"{axis}{i}_cm", (1, 2, 3), 1e2),
        (("t", 1.0), lambda i, axis: f"m{i}.{axis}", (1, -2, -3), 1.0),
    ],
)
def test_other_column_names(capsys, log, markers, tmp_path, time, names, axes, scale):
    """Units from the header, up from the way the line hangs; tolerance: rounding by the units, far below 0.1 nm."""
    table = table_of(markers, names, axes, scale)
    table.insert(0, time[0], np.rint(markers[0] * 1e9) * time[1] / 1e9)
    table.to_csv(tmp_path / "other.csv", index=False, sep=";")
    cable = judged(capsys, tmp_path / "other.csv")
    np.testing.assert_allclose(indicators(cable), indicators(judged(capsys, log)), rtol=1e-6, atol=1e-8)
    assert any("does not say where up is" in note for note in cable["notes"])


def test_unsorted_and_repeated_times_are_mended_and_told(capsys, log, markers, tmp_path):
    table = table_of(markers, lambda i, axis: f"{axis}{i} [m]", (1, 2, 3), 1.0)
    table.insert(0, "time [s]", markers[0])
    mixed = pandas.concat([table.sample(frac=1.0, random_state=1), table[:10]])
    mixed.to_csv(tmp_path / "mixed.csv", index=False)
    cable = judged(capsys, tmp_path / "mixed.csv")
    np.testing.assert_allclose(indicators(cable), indicators(judged(capsys, log)), rtol=1e-9)
    notes = " ".join(cable["notes"])
    assert "frames sorted by time" in notes
    assert "10 frames repeated a time" in notes


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("x1,y1,z1", "no column of time; the columns are x1, y1, z1; expected a column of time"),
        ("time,speed", "no columns of markers; the columns are time, speed; expected a column of time, and for each"),
        ("time,x1,y1,z1,x2,y2", "marker 2 has no z"),
        ("time [min],x1,y1,z1", "column 'time [min]': unit 'min' is not known; use one of s, ms"),
        ("time,x1 [ft],y1,z1", "column 'x1 [ft]': unit 'ft' is not known; use one of m, cm, mm"),
        ("time,x1,y1,z1,x_1", "column 'x_1' is a second x of marker 1"),
        ("time,force,x,y,z", "no columns of markers"),
        ("time,x1 [mm],y1,z1", "lengths in different units: 'x1 [mm]' in mm, 'y1' without a unit; give all columns"),
        ("time,x1,y1,z1,x1", "2 columns are called 'x1'; rename or remove one"),
    ],
)
def test_tables_are_refused_by_name(capsys, tmp_path, header, message):
    path = tmp_path / "table.csv"
    path.write_text(f"{header}\n{','.join('1' for _ in header.split(','))}\n")
    assert message in refused(capsys, path)


@pytest.mark.parametrize("data", [b"", b"\x00\xff\xfe binary \x80", b"one line of text"])
def test_what_is_no_table_is_refused(capsys, tmp_path, data):
    path = tmp_path / "table.csv"
    path.write_bytes(data)
    assert str(path) in refused(capsys, path)


def write_mcap(path: Path, encoding: str, schema: tuple[str, str, bytes], messages: list[tuple[int, bytes]]) -> None:
    with open(path, "wb") as file:
        writer = Writer(file)
        writer.start(profile="other")
        schema_id = writer.register_schema(*schema)
        channel = writer.register_channel("/mocap", encoding, schema_id)
        for t_ns, data in messages:
            writer.add_message(channel, t_ns, data, t_ns)
        writer.finish()


def test_json_of_another_tool(capsys, log, markers, tmp_path):
    """Points in a list below other fields, null where lost, z up; JSON holds float64 exactly."""
    messages = []
    for t, points, seen in zip(*markers, strict=True):
        listed = [{"x": p[1], "y": p[0], "z": -p[2]} if s else None for p, s in zip(points.tolist(), seen, strict=True)]
        body = {"header": {"frame": "pool"}, "rigid": {"markers": listed}}
        messages.append((round(t * 1e9), json.dumps(body).encode()))
    write_mcap(tmp_path / "other.mcap", "json", ("mocap", "jsonschema", b"{}"), messages)
    cable = judged(capsys, tmp_path / "other.mcap", "--channel", "/mocap")
    np.testing.assert_allclose(indicators(cable), indicators(judged(capsys, log)), rtol=1e-9)


def test_protobuf_of_another_tool(capsys, log, markers, tmp_path):
    """foxglove.PosesInFrame, not a number where lost; doubles, so the same but for roundings."""
    messages = []
    for t, points, seen in zip(*markers, strict=True):
        poses = PosesInFrame(frame_id="pool")
        for p, s in zip(points.tolist(), seen, strict=True):
            x, y, z = (p[1], p[0], -p[2]) if s else (np.nan,) * 3
            poses.poses.add().position.MergeFrom(poses.poses[0].position.__class__(x=x, y=y, z=z))
        messages.append((round(t * 1e9), poses.SerializeToString()))
    schema = ("foxglove.PosesInFrame", "protobuf", describe_message(PosesInFrame).SerializeToString())
    write_mcap(tmp_path / "other.mcap", "protobuf", schema, messages)
    cable = judged(capsys, tmp_path / "other.mcap", "--up", "z")
    np.testing.assert_allclose(indicators(cable), indicators(judged(capsys, log)), rtol=1e-9)


def test_other_files_are_refused_by_name(capsys, tmp_path):
    write_mcap(tmp_path / "ros.mcap", "cdr", ("geometry_msgs/PoseArray", "ros2msg", b""), [(0, b"\0")])
    assert "/mocap is cdr geometry_msgs/PoseArray; only protobuf and json are read" in refused(
        capsys, tmp_path / "ros.mcap", "--channel", "/mocap"
    )
    assert "at least three points x, y, z that are numbers; it has /mocap (cdr geometry_msgs/PoseArray)" in (
        refused(capsys, tmp_path / "ros.mcap")
    )
    at_once = [(0, b'{"markers": [[0, 0, 0], [1, 0, 1], [2, 0, 3]]}')] * 5
    write_mcap(tmp_path / "at_once.mcap", "json", ("m", "jsonschema", b"{}"), at_once)
    assert "5 messages have 1 different log times" in refused(capsys, tmp_path / "at_once.mcap")
    assert "has no channel /other; it has /mocap" in refused(capsys, tmp_path / "ros.mcap", "--channel", "/other")
    write_mcap(tmp_path / "empty.mcap", "json", ("speed", "jsonschema", b"{}"), [(0, b'{"speed": 1.0}')])
    assert "holds no list of points x, y, z" in refused(capsys, tmp_path / "empty.mcap", "--channel", "/mocap")
    assert "no markers" in refused(capsys, tmp_path / "empty.mcap")
    assert "cannot open the log" in refused(capsys, tmp_path / "absent.mcap")


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (("--channel", "hand"), "channel hand has no markers"),
        (("--channel", "absent"), "has no channel absent; it has wall, hand, tether, markers"),
        (("--tolerance", "5 kg"), "--tolerance: "),
        (("--tolerance", "0%"), "--tolerance: 0% is not between 0 and 100 %"),
        (("--length", "0"), "--length: 0 is not positive"),
        (("--length", "-2m"), "--length: -2m is not positive"),
        (("--tolerance", "-1%"), "--tolerance: -1% is not between 0 and 100 %"),
        (("--noise", "-1mm"), "--noise: -1mm is not positive"),
    ],
)
def test_mistakes(capsys, log, words, message):
    assert message in refused(capsys, log, *words)


def test_people_see_the_published_figures_beside(capsys, log):
    assert main(["validity", str(log)]) == 0
    shown = capsys.readouterr().err
    for text in ("pool_chain", "published", "e_C [mm]", "12.6", "27.7", "Table II of Drupt", "e_C exceeds 35 mm in"):
        assert text in shown


def test_the_line_behind_the_markers_is_judged(capsys, log):
    """At rest the chain is its own catenary (README: 20 segments 2.1 mm, 50 fewer); moved by hand it is not, and of all
    that loads it the water's resistance to its motion is the largest beside its weight: so the paper has it (V)."""
    cable = judged(capsys, log)
    line = cable["line"]
    assert line["weight_N_per_m"] == pytest.approx((0.1054 - 1000 * 1.3427e-5) * 9.80665, rel=1e-12)
    weight = line["through_ends"]["weight"]
    assert weight["verdict"] == "holds in part"
    assert weight["fails"][0]["start_s"] > 1.0
    seconds = sum(weight[f"seconds_{name}"] for name in ("failing", "holding", "unknown"))
    assert seconds == pytest.approx(30.0, abs=1e-9)
    assert {span["cause"] for span in cable["fails"]} == {"motion"}
    longest = max(weight["fails"], key=lambda span: span["end_s"] - span["start_s"])
    assert longest["cause"] == "motion"
    assert longest["ratios"]["motion"] > longest["ratios"]["acceleration"]
    assert longest["ratios"]["current"] == 0.0
    strict = judged(capsys, log, "--tension-tolerance", "2%")["line"]["through_ends"]["weight"]
    assert strict["seconds_failing"] > weight["seconds_failing"]
    assert "--tension-tolerance: '3 N' is no share" in refused(capsys, log, "--tension-tolerance", "3 N")
