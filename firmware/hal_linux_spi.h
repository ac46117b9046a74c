// The LED driver chain on a spidev node: mode 0, one transfer of the whole chain.
#ifndef LAMELLA_FIRMWARE_HAL_LINUX_SPI_H
#define LAMELLA_FIRMWARE_HAL_LINUX_SPI_H

#include "led_chain.h"
#include "status.h"

struct linux_spi {
  int fd;
  unsigned hz;
  char error[160];
};

enum lam_status linux_spi_open(struct linux_spi* spi, const char* device, double hz);

// Returns when the kernel has shifted the last bit.
// pushed_out: as hal.h says.
enum lam_status linux_spi_shift(struct linux_spi* spi, const uint8_t stream[CHAIN_BYTES],
                                uint8_t pushed_out[CHAIN_BYTES]);

void linux_spi_close(struct linux_spi* spi);

#endif
