// One burst's folder on the rig's disk:
//
//   burst-000012.partial/        burst-000012/ once it is whole
//     begin                      BurstBegin
//     calibration.json           the rig's, as it was then
//     frame-07.raw, .record      a photograph and its FrameOffer; .acked once a host has it
//     timing                     TimingEdges, one record for every 64 edges
//     end                        BurstEnd
//
// Every file is written beside its place, synced and renamed into it. A photograph is kept once its
// record's name is synced; a host's acknowledgement counts once the record's new name is.
#ifndef LAMELLA_FIRMWARE_STORE_BURST_H
#define LAMELLA_FIRMWARE_STORE_BURST_H

#include <stdbool.h>

#include "proto/link.pb.h"
#include "proto/store.pb.h"
#include "store_disk.h"

enum { STORE_MAX_PHOTOGRAPHS = 64 };

enum frame_state { FRAME_NONE, FRAME_HELD, FRAME_ACKNOWLEDGED };

struct held_burst {
  uint64_t id;
  int64_t begun_unix_us;
  bool named_whole;  // its folder's name says so
  bool whole;
  bool flashing_confirmed;  // as it was begun
  char subject[sizeof((lamella_v1_BurstBegin*)0)->subject];
  char why[160];  // why it is not whole
  uint32_t expected, held, acknowledged, damaged;
  uint64_t bytes;
  uint8_t frames[STORE_MAX_PHOTOGRAPHS];  // enum frame_state
};

struct store_ending;

void burst_folder_name(uint64_t id, const char* suffix, char name[DISK_MAX_PATH]);
void burst_path(const struct held_burst* burst, const char* file, char path[DISK_MAX_PATH]);
void burst_frame_path(const struct held_burst* burst, uint32_t frame_id, const char* suffix,
                      char path[DISK_MAX_PATH]);

// All of these: 0, or an errno.
int burst_make(struct disk* disk, const struct held_burst* burst, const uint8_t* calibration,
               size_t calibration_size);
int burst_put_frame(struct disk* disk, const struct held_burst* burst,
                    const lamella_v1_FrameOffer* offer, const uint8_t* bytes);
int burst_put_record(struct disk* disk, const struct held_burst* burst,
                     const lamella_v1_FrameOffer* offer);
int burst_put_end(struct disk* disk, struct held_burst* burst, const struct store_ending* ending);
// The burst is whole from now on, by its name too.
int burst_name_whole(struct disk* disk, struct held_burst* burst);
// Counts as acknowledged whatever becomes of the photograph's bytes.
int burst_acknowledge(struct disk* disk, struct held_burst* burst, uint32_t frame_id);
int burst_remove(struct disk* disk, const struct held_burst* burst);
int burst_clear_folder(struct disk* disk, const char* folder);

// False where there is none, or it is not sound.
bool burst_get_offer(const struct disk* disk, const struct held_burst* burst, uint32_t frame_id,
                     lamella_v1_FrameOffer* offer);
bool burst_get_end(const struct disk* disk, const struct held_burst* burst,
                   lamella_v1_BurstEnd* end);
bool burst_get_timing(const struct disk* disk, const struct held_burst* burst, uint32_t first_edge,
                      lamella_v1_TimingEdges* page);

// Writes `why` from what the folder holds.
void burst_explain(struct held_burst* burst, const lamella_v1_BurstEnd* end);

#endif
