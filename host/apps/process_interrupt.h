// ^C in the middle of long work.
#pragma once

namespace lamella::apps {

// From now on SIGINT, SIGTERM and SIGHUP first remove the outputs that are begun, then end the
// program as they would have. To be called before a thread is started: a thread of its own waits
// for them.
void abandon_outputs_on_interrupt();

}  // namespace lamella::apps
