// The heap of a program that fits.
#pragma once

#include <cstddef>

namespace lamella {

// A fit allocates and frees images by the hundred, and pages given back and asked for again would
// be a tenth of its time: what is freed stays the process's. Does nothing where the C library is
// not glibc.
void keep_heap();

// What will be written soon is there, where the heap is kept, as far as the system knows how: asked
// for in large pieces, pages take two thirds of the time that each takes at its first touch.
void warm_heap(size_t bytes);

}  // namespace lamella
