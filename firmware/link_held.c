#include "link_held.h"

#include <stdio.h>
#include <string.h>

#include "crc32c.h"

#define CODE(name) lamella_v1_Refusal_Code_##name

// In memory: the newest burst, and only once it has ended well.
static bool is_current_burst(const struct session* session, uint64_t burst_id) {
  return session->state == lamella_v1_RigState_IDLE && burst_id != 0 &&
         burst_id == session->burst_id && session->done.burst_id == burst_id;
}

static const struct held_burst* find_on_disk(const struct dialogue* dialogue, uint64_t burst_id) {
  const struct store* store = dialogue->session->store;
  return store->on_disk ? store_find_burst(store, burst_id) : NULL;
}

static bool is_in_memory(const struct dialogue* dialogue, uint64_t burst_id) {
  return !dialogue->session->store->on_disk && is_current_burst(dialogue->session, burst_id);
}

static bool refuse_burst_id(struct dialogue* dialogue, uint32_t id, uint64_t burst_id) {
  const struct session* session = dialogue->session;
  const bool under_way = session_is_busy(session) && burst_id == session->burst_id;
  return link_refuse(dialogue, id, under_way ? CODE(WRONG_STATE) : CODE(NOT_FOUND),
                     under_way ? "the burst is not over" : "the rig holds no such burst");
}

static bool refuse_frame_id(struct dialogue* dialogue, uint32_t id) {
  return link_refuse(dialogue, id, CODE(NOT_FOUND), "the rig holds no such photograph");
}

static bool send_held(struct dialogue* dialogue, uint32_t id, const struct held_burst* burst) {
  lamella_v1_HeldBurst* held = &link_begin(dialogue, id, lamella_v1_Reply_held_tag)->body.held;
  *held = (lamella_v1_HeldBurst){.burst_id = burst->id,
                                 .begun_unix_us = burst->begun_unix_us,
                                 .whole = burst->whole,
                                 .flashing_confirmed = burst->flashing_confirmed,
                                 .frames_held = burst->held,
                                 .frames_acknowledged = burst->acknowledged,
                                 .frames_expected = burst->expected,
                                 .bytes_held = burst->bytes};
  snprintf(held->why, sizeof held->why, "%s", burst->why);
  snprintf(held->subject, sizeof held->subject, "%s", burst->subject);
  return link_send(dialogue);
}

static bool send_held_in_memory(struct dialogue* dialogue, uint32_t id) {
  const struct session* session = dialogue->session;
  const struct store* store = session->store;
  struct held_burst burst = {.id = session->burst_id, .whole = true};
  burst.expected = session->done.frame_count;
  burst.flashing_confirmed = store->current.flashing_confirmed;
  memcpy(burst.subject, store->current.subject, sizeof burst.subject);
  for (size_t i = 0; i < store->count; i++) {
    const struct photograph* photograph = &store->photographs[i];
    burst.acknowledged += photograph->acknowledged;
    burst.held += !photograph->acknowledged;
    burst.bytes += photograph->acknowledged ? 0 : photograph->size;
  }
  return burst.held == 0 || send_held(dialogue, id, &burst);
}

bool link_answer_bursts(struct dialogue* dialogue, uint32_t id) {
  struct store* store = dialogue->session->store;
  if (is_in_memory(dialogue, dialogue->session->burst_id)) {
    if (!send_held_in_memory(dialogue, id)) return false;
  }
  for (size_t i = 0; i < store->burst_count; i++) {
    if (!send_held(dialogue, id, &store->bursts[i])) return false;
  }
  lamella_v1_HeldEnd* end = &link_begin(dialogue, id, lamella_v1_Reply_held_end_tag)->body.held_end;
  end->bursts = store_bursts_held(store);
  end->on_disk = store->on_disk;
  end->free_bytes = store->on_disk ? disk_free_bytes(&store->disk) : 0;
  return link_send(dialogue);
}

static bool send_offer(struct dialogue* dialogue, uint32_t id, const struct photograph* held) {
  lamella_v1_FrameOffer* offer = &link_begin(dialogue, id, lamella_v1_Reply_frame_tag)->body.frame;
  offer->burst_id = dialogue->session->burst_id;
  offer->frame_id = held->frame_id;
  offer->has_frame = true;
  offer->frame = held->frame;
  offer->width = held->width;
  offer->height = held->height;
  offer->size_bytes = (uint32_t)held->size;
  offer->crc32c = held->crc32c;
  offer->marked = held->marked;
  return link_send(dialogue);
}

static bool send_offers_on_disk(struct dialogue* dialogue, uint32_t id,
                                const struct held_burst* burst) {
  const struct disk* disk = &dialogue->session->store->disk;
  for (uint32_t i = 0; i < STORE_MAX_PHOTOGRAPHS; i++) {
    lamella_v1_Reply* reply = link_begin(dialogue, id, lamella_v1_Reply_frame_tag);
    if (burst->frames[i] != FRAME_HELD) continue;
    if (!burst_get_offer(disk, burst, i, &reply->body.frame)) continue;  // lost since: not offered
    if (!link_send(dialogue)) return false;
  }
  return true;
}

// The verdict of a burst that has none says what is missing.
static bool send_done_on_disk(struct dialogue* dialogue, uint32_t id,
                              const struct held_burst* burst) {
  static lamella_v1_BurstEnd end;
  lamella_v1_BurstDone* done = &link_begin(dialogue, id, lamella_v1_Reply_done_tag)->body.done;
  const bool ended = burst_get_end(&dialogue->session->store->disk, burst, &end);
  if (ended) *done = end.done;
  done->burst_id = burst->id;
  if (!burst->whole) {
    done->frame_count = burst->held + burst->acknowledged;
    snprintf(done->verdict, sizeof done->verdict, "PARTIAL: %s", burst->why);
  }
  return link_send(dialogue);
}

static bool send_done(struct dialogue* dialogue, uint32_t id) {
  link_begin(dialogue, id, lamella_v1_Reply_done_tag)->body.done = dialogue->session->done;
  return link_send(dialogue);
}

bool link_answer_frames(struct dialogue* dialogue, uint32_t id, uint64_t burst_id) {
  const struct held_burst* burst = find_on_disk(dialogue, burst_id);
  if (burst != NULL) {
    return send_offers_on_disk(dialogue, id, burst) && send_done_on_disk(dialogue, id, burst);
  }
  if (!is_current_burst(dialogue->session, burst_id)) {
    return refuse_burst_id(dialogue, id, burst_id);
  }
  const struct store* store = dialogue->session->store;
  for (size_t i = 0; i < store->count && !store->on_disk; i++) {
    if (store->photographs[i].acknowledged) continue;
    if (!send_offer(dialogue, id, &store->photographs[i])) return false;
  }
  return send_done(dialogue, id);
}

// Bytes that a host may ask for from any offset on; where `bytes` is NULL they are on disk.
struct blob {
  uint64_t burst_id;
  uint32_t frame_id;
  const uint8_t* bytes;
  size_t size;
};

// With its prefix a chunk of so many fills two TLS records, and leaves no stub of a third.
static const size_t kChunkBytes = 32640;

// Where the next part lies: in memory, or read from the disk into `room`. NULL where the disk does
// not give what it took.
static const uint8_t* find_part(struct store* store, const struct blob* blob, size_t offset,
                                uint8_t* room, size_t* size) {
  const size_t rest = blob->size - offset;
  *size = rest < kChunkBytes ? rest : kChunkBytes;
  if (blob->bytes != NULL) return blob->bytes + offset;
  if (*size > 0) *size = store_read(store, blob->burst_id, blob->frame_id, offset, room, *size);
  return *size > 0 || rest == 0 ? room : NULL;
}

// What a chunk carries is not copied where the connection can do without.
static bool send_part(struct dialogue* dialogue, const uint8_t* part, size_t size) {
  lamella_v1_Chunk* chunk = &dialogue->reply.body.chunk;
  if (dialogue->send_chunk != NULL) {
    return dialogue->send_chunk(dialogue->context, &dialogue->reply, part, size);
  }
  if (part != chunk->data.bytes) memcpy(chunk->data.bytes, part, size);
  chunk->data.size = (pb_size_t)size;
  return link_send(dialogue);
}

// False where the host is gone, or the disk failed: the connection is closed.
static bool send_chunk(struct dialogue* dialogue, const struct blob* blob, size_t* offset) {
  lamella_v1_Chunk* chunk = &dialogue->reply.body.chunk;
  size_t size = 0;
  chunk->data.size = 0;
  const uint8_t* part =
      find_part(dialogue->session->store, blob, *offset, chunk->data.bytes, &size);
  if (part == NULL) return false;
  chunk->offset_bytes = (uint32_t)*offset;
  chunk->crc32c = crc32c_extend(0, part, size);
  *offset += size;
  return send_part(dialogue, part, size);
}

// Chunks from the offset asked for to the end; one empty chunk where nothing is left.
static bool send_blob(struct dialogue* dialogue, uint32_t id, const struct blob* blob,
                      size_t offset) {
  if (offset > blob->size) {
    return link_refuse(dialogue, id, CODE(BAD_REQUEST), "offset_bytes lies beyond the end");
  }
  lamella_v1_Chunk* chunk = &link_begin(dialogue, id, lamella_v1_Reply_chunk_tag)->body.chunk;
  chunk->burst_id = blob->burst_id;
  chunk->frame_id = blob->frame_id;
  chunk->total_bytes = (uint32_t)blob->size;
  do {
    if (!send_chunk(dialogue, blob, &offset)) return false;
    chunk->sequence++;
  } while (offset < blob->size);
  return true;
}

static bool answer_calibration(struct dialogue* dialogue, uint32_t id,
                               const lamella_v1_BlobQuery* query) {
  static uint8_t bytes[1 << 20];  // as large as the rig reads any
  const struct held_burst* burst = find_on_disk(dialogue, query->burst_id);
  struct blob calibration = {query->burst_id, 0, dialogue->calibration, dialogue->calibration_size};
  if (burst == NULL && query->burst_id != 0 && !is_in_memory(dialogue, query->burst_id)) {
    return refuse_burst_id(dialogue, id, query->burst_id);
  }
  if (burst != NULL) {
    char path[DISK_MAX_PATH];
    burst_path(burst, "calibration.json", path);
    const ssize_t size = disk_read(&dialogue->session->store->disk, path, bytes, sizeof bytes);
    if (size < 0) {
      return link_refuse(dialogue, id, CODE(NOT_FOUND), "the burst's calibration is not on disk");
    }
    calibration = (struct blob){burst->id, 0, bytes, (size_t)size};
  }
  return send_blob(dialogue, id, &calibration, query->offset_bytes);
}

bool link_answer_blob(struct dialogue* dialogue, uint32_t id, const lamella_v1_BlobQuery* query) {
  if (query->kind == lamella_v1_BlobQuery_Kind_CALIBRATION) {
    return answer_calibration(dialogue, id, query);
  }
  if (query->kind != lamella_v1_BlobQuery_Kind_PHOTOGRAPH) {
    return link_refuse(dialogue, id, CODE(BAD_REQUEST),
                       "kind is neither photograph nor calibration");
  }
  const struct held_burst* burst = find_on_disk(dialogue, query->burst_id);
  if (burst == NULL && !is_in_memory(dialogue, query->burst_id)) {
    return refuse_burst_id(dialogue, id, query->burst_id);
  }
  struct store* store = dialogue->session->store;
  struct blob photograph = {.burst_id = query->burst_id, .frame_id = query->frame_id};
  if (burst != NULL) {
    photograph.size = store_size(store, query->burst_id, query->frame_id);
  } else {
    const struct photograph* held = store_find(store, query->frame_id);
    if (held != NULL) photograph.bytes = held->bytes;
    if (held != NULL) photograph.size = held->size;
  }
  if (photograph.size == 0) return refuse_frame_id(dialogue, id);
  return send_blob(dialogue, id, &photograph, query->offset_bytes);
}

bool link_answer_timing(struct dialogue* dialogue, uint32_t id,
                        const lamella_v1_TimingQuery* query) {
  struct session* session = dialogue->session;
  const struct held_burst* burst = find_on_disk(dialogue, query->burst_id);
  lamella_v1_TimingEdges* page =
      &link_begin(dialogue, id, lamella_v1_Reply_timing_tag)->body.timing;
  if (burst != NULL) {
    if (!burst_get_timing(&session->store->disk, burst, query->first_edge, page)) {
      *page = (lamella_v1_TimingEdges){.first_edge = query->first_edge};  // it was cut off before
    }
  } else if (is_current_burst(session, query->burst_id)) {
    session_timing(session, query->first_edge, page);
  } else {
    return refuse_burst_id(dialogue, id, query->burst_id);
  }
  return link_send(dialogue);
}

static bool say_acknowledged(struct dialogue* dialogue, uint32_t id, uint32_t frame_id) {
  link_begin(dialogue, id, lamella_v1_Reply_acknowledged_tag)->body.acknowledged.frame_id =
      frame_id;
  return link_send(dialogue);
}

// Said again where the host asks again: the answer may have been lost with the link.
static bool acknowledge_on_disk(struct dialogue* dialogue, uint32_t id,
                                const struct held_burst* burst, uint32_t frame_id) {
  if (frame_id >= STORE_MAX_PHOTOGRAPHS || burst->frames[frame_id] == FRAME_NONE) {
    return refuse_frame_id(dialogue, id);
  }
  if (burst->frames[frame_id] == FRAME_HELD &&
      store_acknowledge(dialogue->session->store, burst->id, frame_id) != LAM_OK) {
    return link_refuse(dialogue, id, CODE(RIG_FAULT), "the rig's disk does not take it");
  }
  return say_acknowledged(dialogue, id, frame_id);
}

static bool acknowledge_in_memory(struct dialogue* dialogue, uint32_t id, uint32_t frame_id) {
  struct store* store = dialogue->session->store;
  for (size_t i = 0; i < store->count; i++) {
    if (store->photographs[i].frame_id != frame_id) continue;
    store->photographs[i].acknowledged = true;
    return say_acknowledged(dialogue, id, frame_id);
  }
  return refuse_frame_id(dialogue, id);
}

bool link_answer_ack(struct dialogue* dialogue, uint32_t id, const lamella_v1_FrameAck* ack) {
  const struct held_burst* burst = find_on_disk(dialogue, ack->burst_id);
  if (burst != NULL) return acknowledge_on_disk(dialogue, id, burst, ack->frame_id);
  if (!is_in_memory(dialogue, ack->burst_id)) {
    return refuse_burst_id(dialogue, id, ack->burst_id);
  }
  return acknowledge_in_memory(dialogue, id, ack->frame_id);
}

bool link_answer_burst_ack(struct dialogue* dialogue, uint32_t id, uint64_t burst_id) {
  if (find_on_disk(dialogue, burst_id) == NULL) return refuse_burst_id(dialogue, id, burst_id);
  if (store_release(dialogue->session->store, burst_id) != LAM_OK) {
    return link_refuse(dialogue, id, CODE(WRONG_STATE),
                       "the burst has photographs: acknowledge those");
  }
  return say_acknowledged(dialogue, id, 0);
}
