"""The scenes. Each reads evidence of witnesses and says what it measured and what was wrong."""
from suite.report import Measure, Result
from witness import compare, led_chain, plan, sigrok

LIGHTS_OFF_LIMIT_US = 10_000
RECORD_LIMIT_US = 10
CRITICAL_GOAL_US = 2
DEVICES = ("/dev/gpiochip", "/dev/spidev", "/dev/video", "/dev/dri/card")


def _expected_codes(evidence, step):
    return led_chain.codes_for(evidence.leds, evidence.plan.roles[step])


def wrong_bits(evidence, burst):
    """[(frame, bit)] that differ from what the rig file and the step ask for, or a word why not."""
    wrong = []
    steps = plan.led_steps(evidence.plan)
    if len(burst.frames) != len(steps):
        return wrong, f"{len(burst.frames)} LED frames were latched, {len(steps)} are planned"
    for i, (step, frame) in enumerate(zip(steps, burst.frames)):
        right = led_chain.encode(_expected_codes(evidence, step))
        if len(frame.bits) != len(right):
            return wrong, f"LED frame {i} has {len(frame.bits)} bits, not {len(right)}"
        wrong += [(i, bit) for bit, pair in enumerate(zip(right, frame.bits)) if pair[0] != pair[1]]
    return wrong, ""


def wrong_codes(evidence, burst):
    """[(pulse, LED)] whose driver compared with another code than the step asks for."""
    steps = plan.led_steps(evidence.plan)
    if len(burst.codes) != len(steps):
        return [], f"{len(burst.codes)} light pulses came, {len(steps)} are planned"
    wrong = []
    for i, (step, codes) in enumerate(zip(steps, burst.codes)):
        right = _expected_codes(evidence, step)
        wrong += [(i, led) for led, (chip, output, _) in enumerate(evidence.leds)
                  if codes[led] != right[chip, output]]
    return wrong, ""


def machine(evidence):
    """The stand-ins are there, and a board that nobody drives is dark."""
    found = evidence.machine
    faults = [f"there is no {device}*" for device in DEVICES
              if not any(name.startswith(device) for name in found["devices"])]
    if found["idle"] != ["1", "0"]:
        faults.append(f"undriven BLANK and LAMP are {found['idle']}, not 1 and 0")
    return Result("the machine: every device is there, an undriven board is dark", [], faults,
                  [f"kernel {found['kernel']}; " + ", ".join(found["devices"])])


def led_frames(evidence):
    """Every LED's level is the one that its step asks for."""
    burst = evidence.bursts["burst"]
    if burst.frames is None:
        wrong, fault = wrong_codes(evidence, burst)
        measures = [Measure("light pulses", len(burst.codes), ""),
                    Measure("LED codes that are wrong", len(wrong), "", 0)]
        return Result("every LED frame is right, as the simulated drivers compare", measures,
                      [fault] if fault else [])
    wrong, fault = wrong_bits(evidence, burst)
    faults = [fault] if fault else []
    faults += [f"LED frame {i} was loaded while BLANK was low" for i, frame
               in enumerate(burst.frames) if not frame.dark]
    longest_us = max((f.last_ns - f.first_ns) / 1e3 for f in burst.frames)
    return Result("every LED frame's bits are right, loaded in the dark", [
        Measure("frames", len(burst.frames), ""),
        Measure("bits", sum(len(frame.bits) for frame in burst.frames), ""),
        Measure("bits that are wrong", len(wrong), "", 0),
        Measure("longest load", longest_us, "us")], faults)


def functions(evidence):
    """Before a burst the drivers are told no levels but zero, in the dark, and what they forget."""
    name = "before a burst the drivers' levels are zero and their functions written"
    if evidence.bursts["burst"].frames is None:
        return Result(name, [], [], skipped="the simulated rig has no bus to look at")
    faults, told = [], 0
    for key, burst in evidence.bursts.items():
        before = burst.frames_before
        faults += [f"{key}: nothing was read back"] if not before else []
        faults += [f"{key}: frame {i} before it has {len(frame.bits)} bits"
                   for i, frame in enumerate(before) if len(frame.bits) != led_chain.BITS]
        faults += [f"{key}: frame {i} before it was loaded while BLANK was low"
                   for i, frame in enumerate(before) if not frame.dark]
        functions_told = [frame.bits for frame in before if frame.functions]
        faults += [f"{key}: other functions" for bits in functions_told if bits != led_chain.FUNCTIONS]
        told += len(functions_told)
    # The chips woke with the board, with random bits; none has forgotten anything since.
    at_start = [frame.bits for frame in evidence.frames_at_start if frame.functions]
    faults += [] if at_start else ["drivers that had just woken were told nothing"]
    faults += ["other functions as the daemon started" for bits in at_start
               if bits != led_chain.FUNCTIONS]
    told += len(at_start)
    return Result(name, [Measure("times that functions were written", told, "")], faults)


def second_decoder(evidence):
    """sigrok reads the same bytes from the VCD."""
    burst = evidence.bursts["burst"]
    name = "sigrok-cli decodes the same bytes from the VCD"
    if burst.vcd_file is None:
        return Result(name, [], [], skipped="the simulated rig has no bus to look at")
    ours = b"".join(led_chain.to_bytes(frame.bits) for frame in burst.frames)
    theirs = sigrok.spi_bytes(burst.vcd_file)
    differ = sum(a != b for a, b in zip(ours, theirs)) + abs(len(ours) - len(theirs))
    measures = [Measure("bytes", len(theirs), ""), Measure("bytes that differ", differ, "", 0)]
    return Result(name, measures, [] if theirs else ["sigrok-cli found no byte"],
                  [sigrok.version()])


def edges(evidence, by_whom=""):
    """Every edge came in order and in time; those of retaken shots have no time, and order alone."""
    burst = evidence.bursts["burst"]
    result = compare.compare(evidence.plan, burst.edges, burst.lines)
    name = f"order and time of every edge of {', '.join(burst.lines)}{by_whom}"
    if result.order_fault:
        return Result(name, [], [result.order_fault])
    timed = [d for d in result.deviations if d.planned.tolerance_us != float("inf")]
    measures = [Measure("edges", len(result.deviations), "")]
    for line in burst.lines:
        worst = compare.largest(timed, line)
        if worst is None:
            continue
        what = f"{line}: largest deviation from plan, at step {worst.planned.step}"
        measures.append(Measure(what, abs(worst.us), "us", worst.planned.tolerance_us))
    faults = [f"{d.planned.line} of step {d.planned.step} was {d.us:.1f} us off"
              for d in timed if d.is_beyond_tolerance()]
    return Result(name, measures, faults)


def ten_bursts(evidence):
    """Every critical edge of ten bursts, the analyser beginning parallel and crossed by turns."""
    name = "every critical edge of ten bursts is within 2 us of plan"
    if evidence.plan_crossed is None:
        return Result(name, [], [], skipped="the simulated rig's clock is exact")
    critical, faults = [], []
    for number, key in enumerate(evidence.bursts_in_turn):
        burst = evidence.bursts[key]
        plan_of_it = evidence.plan_crossed if number % 2 else evidence.plan
        result = compare.compare(plan_of_it, burst.edges, burst.lines)
        faults += [f"{key}: {result.order_fault}"] if result.order_fault else []
        faults += [f"{key}: {burst.record.verdict}"] if "none late" not in burst.record.verdict else []
        critical += [d for d in result.deviations if d.planned.line in compare.CRITICAL]
    measures = [
        Measure("bursts", len(evidence.bursts_in_turn), ""),
        Measure("critical edges", len(critical), ""),
        Measure("largest deviation from plan", max((abs(d.us) for d in critical), default=0), "us",
                CRITICAL_GOAL_US)]
    return Result(name, measures, faults)


def repeats(evidence):
    """A burst of the same daemon from the same start moves every line at the same times."""
    name = "a burst repeats the last one from the same start"
    if evidence.plan_crossed is None:
        return Result(name, [], [], skipped="the simulated rig's clock is exact")
    keys = evidence.bursts_in_turn[0], evidence.bursts_in_turn[2]
    runs = [compare.compare(evidence.plan, evidence.bursts[key].edges, evidence.bursts[key].lines)
            for key in keys]
    faults = [run.order_fault for run in runs if run.order_fault]
    if faults:
        return Result(name, [], faults)
    pairs = [(a, b) for a, b in zip(runs[0].deviations, runs[1].deviations)
             if a.planned.line in compare.CRITICAL]
    apart_us = max(abs(a.us - b.us) for a, b in pairs)
    return Result(name, [Measure("critical edges", len(pairs), ""),
                         Measure("largest difference", apart_us, "us",
                                 pairs[0][0].planned.tolerance_us)], [])


def retake(evidence, key, late_pulse):
    """The step whose light came late is taken again in the same burst, with the same light."""
    name = "a step whose light came late is taken again in the same burst"
    burst = evidence.bursts[key]
    if burst.frames is None:
        return Result(name, [], [], skipped="the fixture of the simulated rig takes nothing again")
    steps = plan.led_steps(evidence.plan)
    late_step = steps[late_pulse]
    again = burst.frames[len(steps):]
    right = led_chain.encode(_expected_codes(evidence, late_step))
    faults = [] if again else ["no LED frame was loaded after the plan's"]
    faults += [f"LED frame {i} of the retake is not step {late_step}'s"
               for i, frame in enumerate(again) if frame.bits != right]
    replaced = [step for step, _ in burst.record.replaced]
    faults += [] if late_step in replaced else [f"the record says that steps {replaced} were replaced"]
    faults += [] if "MARKED" not in burst.record.verdict else [burst.record.verdict]
    return Result(name, [Measure("LED frames after the plan's", len(again), "")], faults,
                  [f"the rig says: {burst.record.verdict}"])


def record_agrees(evidence):
    """The player's own record is true, and its zero is the one that the edges fit."""
    burst = evidence.bursts["burst"]
    name = "the player's record agrees with the witness"
    recorded = [edge for edge in burst.record.edges if edge.line in burst.lines]
    seen = [edge for edge in burst.edges if edge.line in burst.lines]
    if [edge[1:] for edge in recorded] != [edge[1:] for edge in seen]:
        return Result(name, [], [f"{len(recorded)} edges are recorded, {len(seen)} were seen, "
                                 "or in another order"])
    apart_us = [abs(a.t_ns - b.t_ns) / 1e3 for a, b in zip(recorded, seen)]
    zero_ns = compare.compare(evidence.plan, burst.edges, burst.lines).zero_ns
    measures = [Measure("edges", len(apart_us), ""),
                Measure("largest difference", max(apart_us), "us", RECORD_LIMIT_US)]
    if zero_ns is not None:
        measures.append(Measure("the burst's zero, as the edges fit it, after the player's",
                                zero_ns / 1e3 - burst.record.zero_us, "us", RECORD_LIMIT_US))
    return Result(name, measures, [])


def lights_off(evidence, key, how, limit_us=LIGHTS_OFF_LIMIT_US):
    """No light shines that long after it happened."""
    name = f"lights are off after {how}"
    if key not in evidence.lights:
        return Result(name, [], [], skipped="lines in memory end with their process")
    light = evidence.lights[key]
    if light.off_us is None:
        return Result(name, [], [f"the watcher says: {light.told}"])
    return Result(name, [Measure("until every light was off", light.off_us, "us",
                                 limit_us)], [])
