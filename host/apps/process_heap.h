#pragma once

namespace lamella::apps {

// A fit allocates and frees images by the hundred, and pages given back and asked for again would
// be a tenth of its time: what is freed stays the process's. Does nothing where the C library is
// not glibc.
void keep_heap();

}  // namespace lamella::apps
