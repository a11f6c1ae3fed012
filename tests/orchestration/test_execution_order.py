"""What each component sees at each tick, drawn: time runs to the right, one column a tick from t0 on.

A counter `a` gives its number of steps, a relay `b` what it saw. `.` means: not due. Authority: the time model of
the design, worked out by hand for each graph.
"""


def values(trace, name):
    """
    The values of a component with one output, `.` where it was not due.
    """
    steps = {t: value for t, value in trace[name]}
    return [steps.get(float(t), ".") for t in range(7)]


def test_direct(trace):
    """
    a:  0 1 2 3 4 5 6
    b:  0 1 2 3 4 5 6      b runs after a in each tick.
    """
    seen = trace("components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: a.n}}}")
    assert values(seen, "b") == [0, 1, 2, 3, 4, 5, 6]


def test_direct_written_backwards(trace):
    """
    As above, with b above a in the YAML: the order follows the wire.
    """
    seen = trace("components: {b: {model: ./relay.py, inputs: {in: a.n}}, a: {model: ./counter.py}}")
    assert values(seen, "b") == [0, 1, 2, 3, 4, 5, 6]


def test_delayed(trace):
    """
    a:  0 1 2 3 4 5 6
    b: -1 0 1 2 3 4 5      `initial` at t0, then a as the tick began.
    """
    seen = trace(
        "components: {a: {model: ./counter.py},"
        " b: {model: ./relay.py, inputs: {in: {from: a.n, delay: true, initial: -1}}}}"
    )
    assert values(seen, "b") == [-1, 0, 1, 2, 3, 4, 5]


def test_delayed_without_initial_starts_from_zero(trace):
    """
    a:  0 1 2 3 ...    b:  0 0 1 2 ...
    """
    seen = trace(
        "components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: {from: a.n, delay: true}}}}"
    )
    assert values(seen, "b") == [0, 0, 1, 2, 3, 4, 5]


def test_slow_consumer(trace):
    """
    a:  0 1 2 3 4 5 6
    b:  0 . 2 . 4 . 6      b, of period 2 s, sees the end of its own step.
    """
    seen = trace("components: {a: {model: ./counter.py}, b: {model: ./relay.py, period: 2 s, inputs: {in: a.n}}}")
    assert values(seen, "b") == [0, ".", 2, ".", 4, ".", 6]


def test_slow_producer_is_held(trace):
    """
    a:  0 . . 1 . . 2      a has period 3 s
    b:  0 0 0 1 1 1 2
    """
    seen = trace("components: {a: {model: ./counter.py, period: 3 s}, b: {model: ./relay.py, inputs: {in: a.n}}}")
    assert values(seen, "a") == [0, ".", ".", 1, ".", ".", 2]
    assert values(seen, "b") == [0, 0, 0, 1, 1, 1, 2]


def test_slow_producer_delayed(trace):
    """
    a:  0 . . 1 . . 2
    b: -1 0 0 0 1 1 1      one tick later, not one step of a later.
    """
    seen = trace(
        "components: {a: {model: ./counter.py, period: 3 s},"
        " b: {model: ./relay.py, inputs: {in: {from: a.n, delay: true, initial: -1}}}}"
    )
    assert values(seen, "b") == [-1, 0, 0, 0, 1, 1, 1]


def test_slow_consumer_delayed(trace):
    """
    a:  0 1 2 3 4 5 6
    b: -1 . . 2 . . 5      the board as the tick began in which b is due.
    """
    seen = trace(
        "components: {a: {model: ./counter.py},"
        " b: {model: ./relay.py, period: 3 s, inputs: {in: {from: a.n, delay: true, initial: -1}}}}"
    )
    assert values(seen, "b") == [-1, ".", ".", 2, ".", ".", 5]


def test_rates_two_and_three(trace):
    """
    a:  0 . 1 . 2 . 3      period 2 s
    b:  0 . . 1 . . 3      period 3 s: holds a's last value at 3 s, its new one at 6 s.
    """
    seen = trace(
        "components: {a: {model: ./counter.py, period: 2 s}, b: {model: ./relay.py, period: 3 s, inputs: {in: a.n}}}"
    )
    assert values(seen, "a") == [0, ".", 1, ".", 2, ".", 3]
    assert values(seen, "b") == [0, ".", ".", 1, ".", ".", 3]


def test_chain_of_three_rates(trace):
    """
    a:  0 1 2 3 4 5 6
    b:  0 . 2 . 4 . 6
    c:  0 . . 2 . . 6      c sees b's last value.
    """
    seen = trace(
        "components: {a: {model: ./counter.py}, b: {model: ./relay.py, period: 2 s, inputs: {in: a.n}},"
        " c: {model: ./relay.py, period: 3 s, inputs: {in: b.out}}}"
    )
    assert values(seen, "c") == [0, ".", ".", 2, ".", ".", 6]


def test_ring_closed_by_a_delayed_wire(trace):
    """
    b -> c -> b, the way back delayed and one added on it:
    b:  5 6 7 8 9 10 11    5 is the `initial`
    c:  5 6 7 8 9 10 11    direct
    """
    seen = trace(
        "components: {b: {model: ./relay.py, inputs: {in: {sum: [{from: c.out, delay: true, initial: 4}, 1]}}},"
        " c: {model: ./relay.py, inputs: {in: b.out}}}"
    )
    assert values(seen, "b") == [5, 6, 7, 8, 9, 10, 11]
    assert values(seen, "c") == [5, 6, 7, 8, 9, 10, 11]


def test_wire_to_itself(trace):
    """
    b -> b, delayed, doubled:
    b:  1 2 4 8 16 32 64   1 is twice the `initial`
    """
    seen = trace(
        "components: {b: {model: ./relay.py, inputs: {in: {from: b.out, delay: true, initial: 0.5, gain: 2}}}}"
    )
    assert values(seen, "b") == [1, 2, 4, 8, 16, 32, 64]


def test_fan_out(trace):
    """
    a -> b and a -> c, c delayed:
    a:  0 1 2 3 4 5 6
    b:  0 1 2 3 4 5 6
    c:  9 0 1 2 3 4 5
    """
    seen = trace(
        "components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: a.n}},"
        " c: {model: ./relay.py, inputs: {in: {from: a.n, delay: true, initial: 9}}}}"
    )
    assert values(seen, "b") == [0, 1, 2, 3, 4, 5, 6]
    assert values(seen, "c") == [9, 0, 1, 2, 3, 4, 5]


def test_diamond_of_direct_and_delayed(trace):
    """
    a -> b -> d, a -> c -> d, the last wire delayed; d = b + 10 c:
    b:  0  1  2  3  4  5  6
    c:  0  1  2  3  4  5  6
    d:  0  1 12 23 34 45 56
    """
    seen = trace(
        "components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: a.n}},"
        " c: {model: ./relay.py, inputs: {in: a.n}},"
        " d: {model: ./relay.py, inputs: {in: {sum: [b.out, {from: c.out, delay: true, gain: 10}]}}}}"
    )
    assert values(seen, "d") == [0, 1, 12, 23, 34, 45, 56]


def test_sums_go_by_order_in_the_yaml(trace):
    """
    (1e16 + 1) - 1e16 = 0, (1e16 - 1e16) + 1 = 1 in float64: the order written is the order added.
    """
    text = "components: {{b: {{model: ./relay.py, inputs: {{in: {{sum: [{}]}}}}}}}}"
    assert values(trace(text.format("1.0e16, 1, -1.0e16")), "b")[0] == 0
    assert values(trace(text.format("1.0e16, -1.0e16, 1")), "b")[0] == 1


def test_linear_function(trace):
    """
    b = 3 a + 0.5:
    b:  0.5 3.5 6.5 ...
    """
    seen = trace(
        "components: {a: {model: ./counter.py},"
        " b: {model: ./relay.py, inputs: {in: {from: a.n, gain: 3, offset: 0.5}}}}"
    )
    assert values(seen, "b") == [0.5, 3.5, 6.5, 9.5, 12.5, 15.5, 18.5]


def test_slices(trace):
    """
    c sees elements 1 and 2 of b = (7, 8, 9):  8 9
    """
    seen = trace(
        "components: {b: {model: ./relay.py, parameters: {width: 3}, inputs: {in: [7, 8, 9]}},"
        " c: {model: ./relay.py, parameters: {width: 2}, inputs: {in: 'b.out[1:3]'}}}"
    )
    assert seen["c"][0] == (0.0, 8, 9)


def test_init_runs_in_stage_order(trace):
    """
    d <- c <- b <- a at t0, written backwards: each init sees its producer's y(t0), here the 3 of a constant.
    d:  3 3 3 ...
    """
    seen = trace(
        "components: {d: {model: ./relay.py, inputs: {in: c.out}}, c: {model: ./relay.py, inputs: {in: b.out}},"
        " b: {model: ./relay.py, inputs: {in: 3}}}"
    )
    assert values(seen, "d") == [3] * 7


def test_event_sets_a_parameter_at_its_tick(trace):
    """
    a:  0 1 2 12 22 32 42    `by: 10` at 2 s acts on the steps that begin at 2 s and later.
    """
    seen = trace("components: {a: {model: ./counter.py}}\nevents: [{at: 2 s, set: {a.by: 10}}]")
    assert values(seen, "a") == [0, 1, 2, 12, 22, 32, 42]


def test_event_on_a_slow_component_waits_for_its_step(trace):
    """
    a:  0 . 1 . 11 . 21      period 2 s, the event at 3 s: the step from 2 s to 4 s is made with it.
    """
    seen = trace("components: {a: {model: ./counter.py, period: 2 s}}\nevents: [{at: 3 s, set: {a.by: 10}}]")
    assert values(seen, "a") == [0, ".", 1, ".", 11, ".", 21]


def test_event_adds_to_a_signal_for_a_while(trace):
    """
    a:  0 1 2 103 104 5 6    100 from 2 s to 4 s; the counter itself does not know
    b:  0 1 2 103 104 5 6
    """
    seen = trace(
        "components: {a: {model: ./counter.py}, b: {model: ./relay.py, inputs: {in: a.n}}}\n"
        "events: [{at: 2 s, add: {a.n: 100}, until: 4 s}]"
    )
    assert values(seen, "a") == [0, 1, 2, 103, 104, 5, 6]
    assert values(seen, "b") == [0, 1, 2, 103, 104, 5, 6]


def test_event_at_t0_comes_after_init(trace):
    """
    a:  0 10 20 ...          y(t0) is made before any event.
    """
    seen = trace("components: {a: {model: ./counter.py}}\nevents: [{at: 0 s, set: {a.by: 10}}]")
    assert values(seen, "a") == [0, 10, 20, 30, 40, 50, 60]


def test_events_of_one_tick_in_the_order_written(trace):
    """
    a:  0 1 8 15 ...         of `by: 5` and `by: 7` at 1 s the later one stands.
    """
    seen = trace(
        "components: {a: {model: ./counter.py}}\nevents: [{at: 1 s, set: {a.by: 5}}, {at: 1 s, set: {a.by: 7}}]"
    )
    assert values(seen, "a")[:4] == [0, 1, 8, 15]


def test_overlapping_additions(trace):
    """
    a:  0 11 112 103 4 5 6   10 from 0 s to 2 s, 100 from 1 s to 3 s
    """
    seen = trace(
        "components: {a: {model: ./counter.py}}\n"
        "events: [{at: 0 s, add: {a.n: 10}, until: 2 s}, {at: 1 s, add: {a.n: 100}, until: 3 s}]"
    )
    assert values(seen, "a") == [0, 11, 112, 103, 4, 5, 6]
