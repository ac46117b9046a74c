"""Negative controls: a witness that does not find the fault planted for it is no witness."""
from suite.report import Measure, Result
from suite.scenes import wrong_bits, wrong_codes
from witness import compare, led_chain, plan, sigrok

FLIPPED_FRAME, FLIPPED_BIT = 2, 1000
LATE_PULSE = 1
LATE_US = {"sim": 200, "vm": 50}  # beyond the tolerance of each target's rig file
SKIPPED_LATCH = 3

FAULTS = {  # as hil/fixture/hal_planted.h reads them
    "control-flipped-bit": f"flip-bit:{FLIPPED_FRAME}:{FLIPPED_BIT}",
    "control-late-blank": f"late-blank:{LATE_PULSE}:{LATE_US['sim']}",
    "control-skipped-latch": f"skip-latch:{SKIPPED_LATCH}",
}


def flipped_bit(evidence):
    """One bit of 16128: it and no other is found."""
    burst = evidence.bursts["control-flipped-bit"]
    name = f"control: bit {FLIPPED_BIT} of LED frame {FLIPPED_FRAME} is flipped, and found"
    if burst.frames is None:
        wrong, fault = wrong_codes(evidence, burst)
        found = [pulse for pulse, _ in wrong] == [FLIPPED_FRAME]
    else:
        wrong, fault = wrong_bits(evidence, burst)
        found = wrong == [(FLIPPED_FRAME, FLIPPED_BIT)]
    faults = [fault] if fault else []
    return Result(name, [], faults if found else faults + [f"the witness says: {wrong[:5]}"])


def flipped_bit_second_decoder(evidence):
    """sigrok finds it too."""
    name = "control: sigrok-cli finds the flipped bit"
    burst = evidence.bursts["control-flipped-bit"]
    if burst.vcd_file is None:
        return Result(name, [], [], skipped="the simulated rig has no bus to look at")
    right = b"".join(led_chain.to_bytes(led_chain.encode(
        led_chain.codes_for(evidence.leds, evidence.plan.roles[step])))
                     for step in plan.led_steps(evidence.plan))
    differ = [i for i, pair in enumerate(zip(right, sigrok.spi_bytes(burst.vcd_file)))
              if pair[0] != pair[1]]
    at = (FLIPPED_FRAME * led_chain.BITS + FLIPPED_BIT) // 8
    faults = [] if differ == [at] else [f"bytes that differ: {differ[:5]}, not {at}"]
    return Result(name, [], faults)


def late_blank(evidence):
    """One BLANK edge late: it is beyond tolerance, and nothing else is."""
    late_us = LATE_US[evidence.target]
    name = f"control: light pulse {LATE_PULSE} comes {late_us} us late, and is found"
    burst = evidence.bursts["control-late-blank"]
    result = compare.compare(evidence.plan, burst.edges, burst.lines, goes_on=True)
    if result.order_fault:
        return Result(name, [], [result.order_fault])
    late = [d for d in result.deviations if d.is_beyond_tolerance()]
    planned = [e for e in evidence.plan.edges if e.line == "BLANK" and e.value == 0][LATE_PULSE]
    measures = [Measure("deviation found", d.us, "us") for d in late]
    found = [d.planned for d in late] == [planned] and abs(late[0].us - late_us) < 20
    names = ", ".join(f"{d.planned.line} of step {d.planned.step}" for d in late) or "nothing"
    return Result(name, measures, [] if found else [f"beyond tolerance: {names}"])


def skipped_latch(evidence):
    """A LATCH pulse that the player records and the line never sees."""
    name = f"control: LATCH pulse {SKIPPED_LATCH} never comes, and is missed"
    burst = evidence.bursts["control-skipped-latch"]
    if burst.codes is not None:
        wrong, _ = wrong_codes(evidence, burst)
        pulses = sorted({pulse for pulse, _ in wrong})
        return Result(name, [], [] if pulses == [SKIPPED_LATCH] else [f"wrong pulses: {pulses}"],
                      ["found by the codes that the simulated drivers kept"])
    fault = compare.compare(evidence.plan, burst.edges, burst.lines).order_fault
    return Result(name, [], [] if fault and "LATCH" in fault else ["the order seems right"],
                  [f"found: {fault}"])


def no_pull_up(evidence):
    """Without BLANK's pull-up and the monostable a killed sequencer leaves the LEDs lit; the watcher must say so."""
    name = "control: on a board without pull-up and monostable the light stays on, and is seen"
    if "control-no-pull-up" not in evidence.lights:
        return Result(name, [], [], skipped="lines in memory end with their process")
    light = evidence.lights["control-no-pull-up"]
    return Result(name, [], [] if light.told == "lit" else [f"the watcher says: {light.told}"])
