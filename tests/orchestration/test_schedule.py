"""Stages, groups and cycles of small graphs, drawn; authority: the definition of each, worked out by hand."""

import random
import time

from pipeline.schedule import components, cycles, stages


def test_chain_written_backwards():
    """2 -> 1 -> 0"""
    assert stages(3, [(2, 1), (1, 0)]) == (((2,),), ((1,),), ((0,),))


def test_independent_nodes_share_a_stage():
    """0   1   2"""
    assert stages(3, []) == (((0,), (1,), (2,)),)


def test_no_nodes():
    assert stages(0, []) == ()


def test_diamond():
    """1
     ↗   ↘
    0     3     4 is alone: it is in the first stage
     ↘   ↗
       2"""
    assert stages(5, [(0, 1), (0, 2), (1, 3), (2, 3)]) == (((0,), (4,)), ((1,), (2,)), ((3,),))


def test_depth_is_the_longest_path():
    """0 -> 1 -> 2, 0 -> 2"""
    assert stages(3, [(0, 1), (1, 2), (0, 2)]) == (((0,),), ((1,),), ((2,),))


def test_bond():
    """body 1 => line 0: one group, the body first"""
    assert stages(2, [(1, 0)], [(1, 0)]) == (((1, 0),),)


def test_bond_takes_in_what_lies_between():
    """0 -> body 1 -> 2 -> line 3 -> 4
    ======>"""
    assert stages(5, [(0, 1), (1, 2), (2, 3), (1, 3), (3, 4)], [(1, 3)]) == (((0,),), ((1, 2, 3),), ((4,),))


def test_line_between_two_bodies():
    """body 0 => line 1 <= body 2"""
    assert stages(3, [(0, 1), (2, 1)], [(0, 1), (2, 1)]) == (((0, 2, 1),),)


def test_two_bonds_apart_share_a_stage():
    """0 => 1    2 => 3"""
    assert stages(4, [(0, 1), (2, 3)], [(0, 1), (2, 3)]) == (((0, 1), (2, 3)),)


def test_two_bonds_crossed_by_wires_are_one_group():
    """0 => 1, 2 => 3, 0 -> 3 and 2 -> 1: neither pair can run before the other"""
    assert stages(4, [(0, 1), (2, 3), (0, 3), (2, 1)], [(0, 1), (2, 3)]) == (((0, 2, 1, 3),),)


def test_cycles():
    """0 -> 1 -> 2 -> 0, with the short cut 2 -> 1; 3 -> 3; 4 alone"""
    assert cycles(5, [(0, 1), (1, 2), (2, 0), (2, 1), (3, 3)]) == [[0, 1, 2], [3]]


def test_shortest_cycle_through_the_first():
    """0 -> 1 -> 2 -> 0 and 0 -> 2"""
    assert cycles(3, [(0, 1), (1, 2), (2, 0), (0, 2)]) == [[0, 2]]


def test_no_cycle():
    assert cycles(3, [(0, 1), (0, 2), (1, 2)]) == []


def test_random_graphs_against_reachability():
    """Authority: strong connection is mutual reachability, here by transitive closure."""
    rng = random.Random(1)
    for _ in range(200):
        n = rng.randint(1, 8)
        edges = {(rng.randrange(n), rng.randrange(n)) for _ in range(rng.randint(0, 14))}
        reach = [[i == j or (i, j) in edges for j in range(n)] for i in range(n)]
        for k in range(n):
            for i in range(n):
                for j in range(n):
                    reach[i][j] |= reach[i][k] and reach[k][j]
        expected = sorted({tuple(j for j in range(n) if reach[i][j] and reach[j][i]) for i in range(n)})
        assert [tuple(group) for group in components(n, edges)] == expected


def test_random_graphs_run_producers_first():
    """In every graph without cycles each producer runs before its consumer, and groups lie in one stage."""
    rng = random.Random(2)
    for _ in range(200):
        n = rng.randint(2, 9)
        names = rng.sample(range(n), n)
        edges = {(names[i], names[j]) for i in range(n) for j in range(i + 1, n) if rng.random() < 0.3}
        bonds = [edge for edge in sorted(edges) if rng.random() < 0.2]
        found = stages(n, edges, bonds)
        order = [node for stage in found for group in stage for node in group]
        assert sorted(order) == list(range(n))
        assert all(order.index(a) < order.index(b) for a, b in edges)
        group_of = {node: group for stage in found for group in stage for node in group}
        assert all(group_of[a] == group_of[b] for a, b in bonds)
        stage_of = {node: i for i, stage in enumerate(found) for group in stage for node in group}
        assert all(stage_of[a] < stage_of[b] or group_of[a] == group_of[b] for a, b in edges)


def test_a_long_chain_is_no_recursion():
    n = 20_000
    begin = time.perf_counter()
    assert len(stages(n, [(i, i + 1) for i in range(n - 1)])) == n
    assert cycles(n, [(i, (i + 1) % n) for i in range(n)]) == [list(range(n))]
    assert time.perf_counter() - begin < 20.0  # measured: 0.3 s; quadratic work would take minutes
