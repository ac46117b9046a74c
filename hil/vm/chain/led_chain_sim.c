// SPDX-License-Identifier: GPL-2.0-or-later
/*
 * Seven TLC5951 in a row on the simulated board's lines SPI_SCK, SPI_MOSI, LATCH, and SPI_MISO at
 * their end. Written from the data sheet (TI SBVS127E, 9.4.5 and 9.4.6), not from the firmware:
 * 288 bits a chip; a rising LATCH takes them as greyscale where it was low at the last clock, and
 * then puts the functions into the register; where it was high then, bits 0 to 198 are functions.
 *
 * The master of this machine (spi-gpio) looks at MISO after its clock's rising edge, where a real
 * one looks at the edge: so the output moves with the falling one.
 */
#include "led_chain_sim.h"

#include <linux/bitops.h>
#include <linux/module.h>
#include <linux/types.h>

enum { LINE_SCK, LINE_MOSI, LINE_MISO, LINE_LATCH = 4 }; /* as hil/vm/rig.dtsi has the lines */
enum { CHIPS = 7, CHIP_BITS = 288, FUNCTION_BITS = 199, BITS = CHIPS * CHIP_BITS };

static u8 shifted[BITS]; /* a ring; the bit that came first is at `oldest` */
static unsigned int oldest;
static unsigned int status_left; /* cells at the far end that hold status, not shifted-in bits */
static u8 functions[BITS];
static unsigned int clocks; /* in all, modulo one frame */
static bool sck, latch, latch_at_clock;

static int chips; /* that the wires reach; to set it is to take their supply away for a moment */
static int flipped_bit = -1;    /* of every frame; -1: none */
static int forgetful_chip = -1; /* takes no functions; -1: none */
module_param(flipped_bit, int, 0644);
module_param(forgetful_chip, int, 0644);

static unsigned int length(void) { return chips * CHIP_BITS; }

/* Random, and the same in every run. */
static void power_up(void) {
  u32 seed = 0x2545f491;
  unsigned int i;

  for (i = 0; i < BITS; i++) {
    seed ^= seed << 13;
    seed ^= seed >> 17;
    seed ^= seed << 5;
    shifted[i] = seed >> 31;
    functions[i] = seed >> 30 & 1;
  }
  oldest = status_left = 0;
}

static int set_chips(const char* text, const struct kernel_param* param) {
  int number, failed = kstrtoint(text, 10, &number);

  if (failed) return failed;
  if (number < 1 || number > CHIPS) return -ERANGE;
  chips = number;
  power_up();
  return 0;
}

static const struct kernel_param_ops chips_ops = {.set = set_chips, .get = param_get_int};
module_param_cb(chips, &chips_ops, &chips, 0644);

/* Of cell `cell` while it holds status: nothing is said above the functions. */
static u8 status_bit(unsigned int cell) {
  return cell % CHIP_BITS < FUNCTION_BITS ? functions[cell] : 0;
}

/* Cell 0 is where bits enter. */
static u8 cell_bit(unsigned int cell) {
  const unsigned int since = length() - status_left;

  if (cell >= since) return status_bit(cell - since);
  return shifted[(oldest + length() - 1 - cell) % length()];
}

static void clock_in(u8 bit) {
  shifted[oldest] = clocks == flipped_bit ? !bit : bit;
  oldest = oldest + 1 == length() ? 0 : oldest + 1;
  clocks = clocks + 1 == BITS ? 0 : clocks + 1;
  if (status_left > 0) status_left--;
  latch_at_clock = latch;
}

static void take_functions(void) {
  unsigned int cell;

  for (cell = 0; cell < length(); cell++) {
    if (cell % CHIP_BITS < FUNCTION_BITS && cell / CHIP_BITS != forgetful_chip)
      functions[cell] = cell_bit(cell);
  }
}

void led_chain_hear(unsigned long* levels) {
  const bool was_high = sck, was_latched = latch;

  sck = *levels >> LINE_SCK & 1;
  latch = *levels >> LINE_LATCH & 1;
  if (sck == was_high && latch == was_latched) return;
  if (chips == 0) set_chips("7", NULL);
  if (sck && !was_high) clock_in(*levels >> LINE_MOSI & 1);
  if (latch && !was_latched && latch_at_clock)
    take_functions();
  else if (latch && !was_latched)
    status_left = length();
  if (!sck) __assign_bit(LINE_MISO, levels, cell_bit(length() - 1));
}
