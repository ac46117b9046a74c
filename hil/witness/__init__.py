"""What really happened on the lines, from witnesses other than the firmware."""
