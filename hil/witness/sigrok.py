"""A second opinion on the SPI bus: sigrok-cli's decoder, which knows nothing of this project."""
import re
import subprocess

# sigrok expands a file into samples: 64 ns keeps every edge of a bus of GPIO lines apart, and idle
# stretches are cut short.
SAMPLE_NS = 64
LONGEST_IDLE_SAMPLES = 1000


def version():
    """The decoder that was asked, for the report."""
    text = subprocess.run(["sigrok-cli", "--version"], check=True, capture_output=True).stdout
    return text.decode().splitlines()[0]


def spi_bytes(vcd_file):
    """Every byte on MOSI, in order."""
    done = subprocess.run(
        ["sigrok-cli", "-i", vcd_file,
         "-I", f"vcd:downsample={SAMPLE_NS}:compress={LONGEST_IDLE_SAMPLES}",
         "-P", "spi:clk=SPI_SCK:mosi=SPI_MOSI:cpol=0:cpha=0:wordsize=8", "-A", "spi=mosi-data"],
        check=True, capture_output=True)
    return bytes(int(word, 16) for word in
                 re.findall(r"^spi-1: ([0-9A-F]{2})$", done.stdout.decode(), re.M))
