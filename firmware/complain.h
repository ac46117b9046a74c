// What the daemon says on standard error.
#ifndef LAMELLA_FIRMWARE_COMPLAIN_H
#define LAMELLA_FIRMWARE_COMPLAIN_H

// One line, its end added. What a terminal would obey, of a file or of an argument, stands as an
// escape: "\x1b".
__attribute__((format(printf, 1, 2))) void complain(const char* format, ...);

#endif
