"""The rig's disk is full, fills up while a burst is written, or gives back what it was not given."""
from pathlib import Path

from suite.camera import STEPS
from suite.report import Measure, Result, expect

REFUSED = 3  # the exit code of a host whose rig refused or failed
LONGEST_S = 150
EXPOSED_BEFORE_FULL = 6
LEFT_KB = 8000  # several times what a burst asks for, so that it begins


def _take_by_button(world):
    """A whole burst that stays on the disk."""
    world.press()
    world.must("await '! is_stored'; await is_stored")


def disk_full(world):
    """No room for a burst: refused before any light; what was whole stays."""
    _take_by_button(world)
    before = world.held()
    world.must("cat /dev/zero >/var/lamella/filler 2>/dev/null; sync")
    exposed = world.count("exposures || true")
    status, _, errors = world.capture("full")
    faults = []
    expect(faults, status == REFUSED and "STORE_FULL" in errors, f"exit {status}: {errors}")
    expect(faults, world.count("exposures || true") == exposed, "a camera was exposed all the same")
    dark = world.must('cat "$(line BLANK)/value" "$(line LAMP)/value"')
    expect(faults, dark == ["1", "0"], f"BLANK and LAMP are {dark}")
    world.must("rm /var/lamella/filler; sync")
    expect(faults, before and world.held() == before, f"{before} became {world.held()}")
    return Result("disk full: refused, dark, and what was whole stays", [], faults, [errors])


def disk_fills(world):
    """The disk takes some photographs of a burst, then somebody else fills it."""
    faults, before = [], world.held()
    exposed = world.count("exposures || true")
    world.must(f"leave_free {LEFT_KB}")
    host = world.host.start("capture", "--rig", world.line.address, "--flashing-confirmed", "--out",
                            world.out / "filled")
    world.must(f"await '[ $(exposures) -ge {exposed + EXPOSED_BEFORE_FULL} ]'; fill_disk")
    _, errors = host.communicate(timeout=LONGEST_S)
    dark = world.must('cat "$(line BLANK)/value" "$(line LAMP)/value"')
    expect(faults, host.returncode == REFUSED and "No space left" in errors,
           f"exit {host.returncode}: {errors.strip()}")
    expect(faults, dark == ["1", "0"], f"BLANK and LAMP are {dark}")
    world.must("empty_disk")
    status, _, cleared = world.host.run("rig", "abort", "--rig", world.line.address)
    expect(faults, status == 0, f"rig abort: exit {status}: {cleared}")
    held = world.held()
    new = [burst for number, burst in held.items() if number not in before]
    expect(faults, all(held.get(number) == burst for number, burst in before.items()),
           f"{before} became {held}")
    expect(faults, len(new) == 1 and not new[0]["whole"] and new[0]["why"],
           f"of the burst the rig says {new}")
    made = world.count("exposures || true") - exposed
    kept = sum(burst["photographs_held"] for burst in new)
    faults += _fetched(world, new)
    return Result("the disk fills up while a burst is written: dark, plainly partial, nothing lost",
                  [Measure("exposures made of it", made, "", STEPS - 1),
                   Measure("photographs kept of it", kept, "")], faults,
                  [errors.strip(), *(burst["why"] for burst in new)])


def _fetched(world, new):
    """Faults of what a host gets of these bursts: all that the rig says it kept, each photograph right."""
    faults = []
    _, bursts, errors = world.sync("filled-synced")
    for burst in new:
        if not burst["photographs_held"]:
            continue
        got = bursts.get(burst["burst"], {}).get("session")
        if not got:
            faults.append(f"burst {burst['burst']} did not come: {errors}")
            continue
        count, wrong = world.wrong(Path(got))
        expect(faults, count == burst["photographs_held"],
               f"{count} of {burst['photographs_held']} photographs came: {errors}")
        faults += wrong
    return faults


def flipped_byte(world):
    """Control: the disk gives back another byte than it was given."""
    _take_by_button(world)
    raw = world.must("ls /var/lamella/store/burst-*/*.raw")[7]
    world.must(f"printf X | busybox dd of={raw} bs=1 seek=5000 conv=notrunc 2>/dev/null; sync")
    world.must("unserve; serve")
    status, bursts, errors = world.sync("flipped")
    told = errors or "; ".join(burst["why"] for burst in bursts.values() if burst["why"])
    faults = [] if status != 0 and told else [f"exit {status}: the flipped byte was not found"]
    return Result("control: a byte of a photograph on the disk is flipped, and found", [], faults,
                  [told])


SCENES = (disk_full, disk_fills, flipped_byte)
