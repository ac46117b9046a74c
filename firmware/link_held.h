// What the rig holds of bursts that are over, for a host: the list of them, their photographs,
// calibration and timing from any byte on, and leave to forget them. From memory or from its disk.
#ifndef LAMELLA_FIRMWARE_LINK_HELD_H
#define LAMELLA_FIRMWARE_LINK_HELD_H

#include "link_answer.h"

// All of these: false where the host is gone.
bool link_answer_bursts(struct dialogue* dialogue, uint32_t id);
bool link_answer_frames(struct dialogue* dialogue, uint32_t id, uint64_t burst_id);
bool link_answer_blob(struct dialogue* dialogue, uint32_t id, const lamella_v1_BlobQuery* query);
bool link_answer_timing(struct dialogue* dialogue, uint32_t id,
                        const lamella_v1_TimingQuery* query);
bool link_answer_ack(struct dialogue* dialogue, uint32_t id, const lamella_v1_FrameAck* ack);
bool link_answer_burst_ack(struct dialogue* dialogue, uint32_t id, uint64_t burst_id);

#endif
