#include "link_answer.h"

#include <pb_decode.h>
#include <stdio.h>
#include <string.h>

#include "crc32c.h"

#define CODE(name) lamella_v1_Refusal_Code_##name

static const char kFirmwareVersion[] = "0.1.0";

static lamella_v1_Reply* begin(struct dialogue* dialogue, uint32_t request_id, pb_size_t body) {
  dialogue->reply = (lamella_v1_Reply)lamella_v1_Reply_init_zero;
  dialogue->reply.request_id = request_id;
  dialogue->reply.which_body = body;
  return &dialogue->reply;
}

static bool send(struct dialogue* dialogue) {
  return dialogue->send(dialogue->context, &dialogue->reply);
}

bool link_refuse(struct dialogue* dialogue, uint32_t request_id, lamella_v1_Refusal_Code code,
                 const char* reason) {
  lamella_v1_Refusal* refusal =
      &begin(dialogue, request_id, lamella_v1_Reply_refusal_tag)->body.refusal;
  refusal->code = code;
  snprintf(refusal->reason, sizeof refusal->reason, "%s", reason);
  return send(dialogue);
}

static bool refuse_status(struct dialogue* dialogue, uint32_t id, enum lam_status status) {
  const lamella_v1_Refusal_Code code = status == LAM_UNSAFE ? CODE(UNSAFE) : CODE(WRONG_STATE);
  return link_refuse(dialogue, id, code, dialogue->session->refusal);
}

static bool send_status(struct dialogue* dialogue, uint32_t id) {
  lamella_v1_Reply* reply = begin(dialogue, id, lamella_v1_Reply_status_tag);
  session_status(dialogue->session, &reply->body.status);
  return send(dialogue);
}

// A wrong version is answered, then the connection closed: nothing later can be understood.
static bool answer_hello(struct dialogue* dialogue, uint32_t id, const lamella_v1_Hello* hello) {
  if (hello->protocol_version != LINK_PROTOCOL_VERSION) {
    link_refuse(dialogue, id, CODE(VERSION), "this rig speaks protocol version 1");
    return false;
  }
  dialogue->greeted = true;
  lamella_v1_Welcome* welcome = &begin(dialogue, id, lamella_v1_Reply_welcome_tag)->body.welcome;
  welcome->protocol_version = LINK_PROTOCOL_VERSION;
  snprintf(welcome->firmware_version, sizeof welcome->firmware_version, "%s", kFirmwareVersion);
  snprintf(welcome->hal, sizeof welcome->hal, "%s", dialogue->session->hal->name);
  welcome->led_count = (uint32_t)dialogue->session->rig->led_count;
  welcome->camera_count = 2;
  return send(dialogue);
}

static bool answer_burst(struct dialogue* dialogue, uint32_t id,
                         const lamella_v1_BurstRequest* request) {
  struct session* session = dialogue->session;
  const enum lam_status status = session_request_burst(session, request->discard_held);
  if (status != LAM_OK) return refuse_status(dialogue, id, status);
  lamella_v1_BurstAccepted* accepted =
      &begin(dialogue, id, lamella_v1_Reply_accepted_tag)->body.accepted;
  accepted->burst_id = session->burst_id;
  accepted->step_count = (uint32_t)session->plan.count;
  accepted->planned_us = session->plan.duration_us;
  return send(dialogue);
}

static bool answer_abort(struct dialogue* dialogue, uint32_t id) {
  const enum lam_status status = session_abort(dialogue->session);
  return status == LAM_OK ? send_status(dialogue, id) : refuse_status(dialogue, id, status);
}

static bool is_current_burst(const struct session* session, uint64_t burst_id) {
  return session->state == lamella_v1_RigState_IDLE && burst_id != 0 &&
         burst_id == session->burst_id && session->done.burst_id == burst_id;
}

static bool refuse_burst_id(struct dialogue* dialogue, uint32_t id) {
  const bool idle = dialogue->session->state == lamella_v1_RigState_IDLE;
  return link_refuse(dialogue, id, idle ? CODE(NOT_FOUND) : CODE(WRONG_STATE),
                     idle ? "the rig holds no such burst" : "the burst is not over");
}

static bool send_offer(struct dialogue* dialogue, uint32_t id, const struct photograph* held) {
  lamella_v1_FrameOffer* offer = &begin(dialogue, id, lamella_v1_Reply_frame_tag)->body.frame;
  offer->burst_id = dialogue->session->burst_id;
  offer->frame_id = held->frame_id;
  offer->has_frame = true;
  offer->frame = held->frame;
  offer->width = held->width;
  offer->height = held->height;
  offer->size_bytes = (uint32_t)held->size;
  offer->crc32c = held->crc32c;
  offer->marked = held->marked;
  return send(dialogue);
}

static bool send_done(struct dialogue* dialogue, uint32_t id) {
  begin(dialogue, id, lamella_v1_Reply_done_tag)->body.done = dialogue->session->done;
  return send(dialogue);
}

static bool answer_frames(struct dialogue* dialogue, uint32_t id, uint64_t burst_id) {
  if (!is_current_burst(dialogue->session, burst_id)) return refuse_burst_id(dialogue, id);
  const struct store* store = dialogue->session->store;
  for (size_t i = 0; i < store->count; i++) {
    if (store->photographs[i].acknowledged) continue;
    if (!send_offer(dialogue, id, &store->photographs[i])) return false;
  }
  return send_done(dialogue, id);
}

// Bytes that a host may ask for from any offset on.
struct blob {
  uint64_t burst_id;
  uint32_t frame_id;
  const uint8_t* bytes;
  size_t size;
};

static bool send_chunk(struct dialogue* dialogue, uint32_t id, const struct blob* blob,
                       size_t offset, uint32_t sequence) {
  lamella_v1_Chunk* chunk = &begin(dialogue, id, lamella_v1_Reply_chunk_tag)->body.chunk;
  chunk->burst_id = blob->burst_id;
  chunk->frame_id = blob->frame_id;
  chunk->sequence = sequence;
  chunk->offset_bytes = (uint32_t)offset;
  chunk->total_bytes = (uint32_t)blob->size;
  const size_t rest = blob->size - offset;
  const size_t size = rest < sizeof chunk->data.bytes ? rest : sizeof chunk->data.bytes;
  chunk->data.size = (pb_size_t)size;
  memcpy(chunk->data.bytes, blob->bytes + offset, size);
  chunk->crc32c = crc32c_extend(0, chunk->data.bytes, size);
  return send(dialogue);
}

// Chunks from the offset asked for to the end; one empty chunk where nothing is left.
static bool send_blob(struct dialogue* dialogue, uint32_t id, const struct blob* blob,
                      size_t offset) {
  if (offset > blob->size) {
    return link_refuse(dialogue, id, CODE(BAD_REQUEST), "offset_bytes lies beyond the end");
  }
  uint32_t sequence = 0;
  do {
    if (!send_chunk(dialogue, id, blob, offset, sequence++)) return false;
    offset += dialogue->reply.body.chunk.data.size;
  } while (offset < blob->size);
  return true;
}

static bool answer_blob(struct dialogue* dialogue, uint32_t id, const lamella_v1_BlobQuery* query) {
  if (query->kind == lamella_v1_BlobQuery_Kind_CALIBRATION) {
    const struct blob calibration = {0, 0, dialogue->calibration, dialogue->calibration_size};
    return send_blob(dialogue, id, &calibration, query->offset_bytes);
  }
  if (query->kind != lamella_v1_BlobQuery_Kind_PHOTOGRAPH) {
    return link_refuse(dialogue, id, CODE(BAD_REQUEST),
                       "kind is neither photograph nor "
                       "calibration");
  }
  if (!is_current_burst(dialogue->session, query->burst_id)) return refuse_burst_id(dialogue, id);
  const struct photograph* held = store_find(dialogue->session->store, query->frame_id);
  if (held == NULL) {
    return link_refuse(dialogue, id, CODE(NOT_FOUND), "the rig holds no such photograph");
  }
  const struct blob photograph = {query->burst_id, held->frame_id, held->bytes, held->size};
  return send_blob(dialogue, id, &photograph, query->offset_bytes);
}

static bool answer_ack(struct dialogue* dialogue, uint32_t id, const lamella_v1_FrameAck* ack) {
  if (!is_current_burst(dialogue->session, ack->burst_id)) return refuse_burst_id(dialogue, id);
  struct photograph* held = store_find(dialogue->session->store, ack->frame_id);
  if (held == NULL) {
    return link_refuse(dialogue, id, CODE(NOT_FOUND), "the rig holds no such photograph");
  }
  held->acknowledged = true;
  begin(dialogue, id, lamella_v1_Reply_acknowledged_tag)->body.acknowledged.frame_id =
      ack->frame_id;
  return send(dialogue);
}

static bool answer_timing(struct dialogue* dialogue, uint32_t id,
                          const lamella_v1_TimingQuery* query) {
  const struct session* session = dialogue->session;
  if (!is_current_burst(session, query->burst_id)) return refuse_burst_id(dialogue, id);
  session_timing(session, query->first_edge,
                 &begin(dialogue, id, lamella_v1_Reply_timing_tag)->body.timing);
  return send(dialogue);
}

static bool may_be_asked_while_playing(pb_size_t body) {
  return body == lamella_v1_Request_hello_tag || body == lamella_v1_Request_status_tag ||
         body == lamella_v1_Request_abort_tag;
}

static bool answer_request(struct dialogue* dialogue, const lamella_v1_Request* request) {
  const uint32_t id = request->request_id;
  switch (request->which_body) {
    case lamella_v1_Request_hello_tag:
      return answer_hello(dialogue, id, &request->body.hello);
    case lamella_v1_Request_status_tag:
      return send_status(dialogue, id);
    case lamella_v1_Request_burst_tag:
      return answer_burst(dialogue, id, &request->body.burst);
    case lamella_v1_Request_abort_tag:
      return answer_abort(dialogue, id);
    case lamella_v1_Request_blob_tag:
      return answer_blob(dialogue, id, &request->body.blob);
    case lamella_v1_Request_ack_tag:
      return answer_ack(dialogue, id, &request->body.ack);
    case lamella_v1_Request_timing_tag:
      return answer_timing(dialogue, id, &request->body.timing);
    case lamella_v1_Request_frames_tag:
      return answer_frames(dialogue, id, request->body.frames.burst_id);
    default:
      return link_refuse(dialogue, id, CODE(BAD_REQUEST), "a request that this rig does not know");
  }
}

bool link_answer(struct dialogue* dialogue, const uint8_t* message, size_t length) {
  static lamella_v1_Request request;
  pb_istream_t stream = pb_istream_from_buffer(message, length);
  if (!pb_decode(&stream, lamella_v1_Request_fields, &request)) {
    return link_refuse(dialogue, 0, CODE(BAD_REQUEST), "not a request, or a field is too long");
  }
  if (request.request_id == 0) {
    return link_refuse(dialogue, 0, CODE(BAD_REQUEST), "request_id 0 is for events");
  }
  if (!dialogue->greeted && request.which_body != lamella_v1_Request_hello_tag) {
    return link_refuse(dialogue, request.request_id, CODE(BAD_REQUEST), "say hello first");
  }
  if (dialogue->session->playing && !may_be_asked_while_playing(request.which_body)) {
    return link_refuse(dialogue, request.request_id, CODE(WRONG_STATE), "a burst is under way");
  }
  return answer_request(dialogue, &request);
}

bool link_tell_news(struct dialogue* dialogue) {
  struct session* session = dialogue->session;
  const bool news = session->has_news, progress = session->has_progress;
  if (!dialogue->greeted || (!news && !progress)) return true;
  session->has_news = session->has_progress = false;
  const bool over = news && session->state == lamella_v1_RigState_IDLE;
  return over ? send_done(dialogue, 0) : send_status(dialogue, 0);
}
