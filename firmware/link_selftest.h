// What the rig says to a request for its self-test.
#ifndef LAMELLA_FIRMWARE_LINK_SELFTEST_H
#define LAMELLA_FIRMWARE_LINK_SELFTEST_H

#include "link_answer.h"

bool link_answer_selftest(struct dialogue* dialogue, uint32_t id,
                          const lamella_v1_SelftestRequest* request);

#endif
