/* SPDX-License-Identifier: GPL-2.0-or-later */
/* LED drivers on the simulated lines: gpio-sim calls this whenever lines of the board were set. */
#ifndef LAMELLA_LED_CHAIN_SIM_H
#define LAMELLA_LED_CHAIN_SIM_H

/* The levels of all lines; MISO's is changed to what leaves the last chip. */
void led_chain_hear(unsigned long* levels);

#endif
