// The rig without a computer: from power-on over the self-test to ready, from the button over the
// countdown to a session in the store, and what light and buzzer say meanwhile.
//
// Who has the rig: whoever asked first, until that burst is over. A host that is merely connected
// does not have it. During countdown and self-test a host's burst is refused, during a host's
// burst the button is. A rig with a part that was found bad, and not good since, refuses the
// button; a host may still ask for a burst, but not where that is the wire that darkens all lights
// (session.unfit).
//
//   TESTING --good--> READY --click--> COUNTDOWN --over--> (session) --> VERDICT --> READY
//   TESTING --bad--> FAULT --click--> TESTING      READY --held--> PAIRING --let go--> READY
#ifndef LAMELLA_FIRMWARE_STANDALONE_H
#define LAMELLA_FIRMWARE_STANDALONE_H

#include "panel.h"
#include "selftest.h"
#include "session.h"

enum standalone_state {
  STANDALONE_TESTING,
  STANDALONE_READY,
  STANDALONE_COUNTDOWN,
  STANDALONE_BURST,
  STANDALONE_VERDICT,  // good, marked or refused, for some seconds
  STANDALONE_FAULT,
  STANDALONE_PAIRING,
};

struct standalone {
  const struct rig* rig;
  struct hal* hal;
  struct session* session;
  struct selftest* selftest;
  unsigned parts;   // what is tested at power-on, and again after a fault
  bool has_button;  // a click starts a burst
  // The pairing code, which light and buzzer show instead while there is one. NULL: there is none.
  bool (*code_light)(void* context, bool* light);
  void* code_context;

  enum standalone_state state;
  struct panel panel;
  double since_us;          // in this state
  bool ready_lit, buzzing;  // the lines as they are
  bool lines_failed;
};

// Begins with the quick self-test of these parts.
void standalone_init(struct standalone* alone, struct session* session, struct selftest* selftest,
                     unsigned parts);

// Does what is due: feels the button, tests the next piece, shows the code, tells the service
// manager. Returns when it is due again, on the rig's clock.
double standalone_tend(void* alone);

// LAM_WRONG_STATE, with a reason, while the rig is at something else.
enum lam_status standalone_request_selftest(struct standalone* alone, unsigned parts, bool learning,
                                            const char** why);

// The button is down and has been for long enough that a host may be paired.
bool standalone_is_held(const struct standalone* alone);

#endif
