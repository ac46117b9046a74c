#include "hal_linux_spi.h"

#include <errno.h>
#include <fcntl.h>
#include <linux/spi/spidev.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <sys/ioctl.h>
#include <unistd.h>

static enum lam_status fail(struct linux_spi* spi, const char* what, const char* why) {
  snprintf(spi->error, sizeof spi->error, "%.80s: %s", what, why);
  return LAM_HARDWARE;
}

static bool configure(const struct linux_spi* spi) {
  uint8_t mode = SPI_MODE_0;
  uint8_t bits = 8;
  uint32_t hz = spi->hz;
  return ioctl(spi->fd, SPI_IOC_WR_MODE, &mode) == 0 &&
         ioctl(spi->fd, SPI_IOC_WR_BITS_PER_WORD, &bits) == 0 &&
         ioctl(spi->fd, SPI_IOC_WR_MAX_SPEED_HZ, &hz) == 0;
}

enum lam_status linux_spi_open(struct linux_spi* spi, const char* device, double hz) {
  *spi = (struct linux_spi){.hz = (unsigned)hz};
  spi->fd = open(device, O_RDWR | O_CLOEXEC);
  if (spi->fd < 0) return fail(spi, device, strerror(errno));
  if (configure(spi)) return LAM_OK;
  const int reason = errno;
  linux_spi_close(spi);
  return fail(spi, device, strerror(reason));
}

enum lam_status linux_spi_shift(struct linux_spi* spi, const uint8_t stream[CHAIN_BYTES],
                                uint8_t pushed_out[CHAIN_BYTES]) {
  const struct spi_ioc_transfer transfer = {.tx_buf = (uintptr_t)stream,
                                            .rx_buf = (uintptr_t)pushed_out,
                                            .len = CHAIN_BYTES,
                                            .speed_hz = spi->hz,
                                            .bits_per_word = 8};
  const int sent = ioctl(spi->fd, SPI_IOC_MESSAGE(1), &transfer);
  if (sent == CHAIN_BYTES) return LAM_OK;
  return fail(spi, "shifting the LED chain", sent < 0 ? strerror(errno) : "cut short");
}

void linux_spi_close(struct linux_spi* spi) {
  if (spi->fd >= 0) close(spi->fd);
  spi->fd = -1;
}
