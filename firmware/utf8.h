// Text as UTF-8.
#ifndef LAMELLA_FIRMWARE_UTF8_H
#define LAMELLA_FIRMWARE_UTF8_H

#include <stdbool.h>
#include <stddef.h>

// Bytes of the character that begins here; 0 where none does.
size_t utf8_bytes(const unsigned char* at, const unsigned char* end);
bool utf8_is_valid(const char* text);

#endif
