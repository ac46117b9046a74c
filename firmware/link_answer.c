#include "link_answer.h"

#include <pb_decode.h>
#include <stdio.h>
#include <string.h>

#include "link_held.h"
#include "link_selftest.h"
#include "pattern.h"
#include "utf8.h"

#define CODE(name) lamella_v1_Refusal_Code_##name

lamella_v1_Reply* link_begin(struct dialogue* dialogue, uint32_t request_id, pb_size_t body) {
  dialogue->reply = (lamella_v1_Reply)lamella_v1_Reply_init_zero;
  dialogue->reply.request_id = request_id;
  dialogue->reply.which_body = body;
  return &dialogue->reply;
}

bool link_send(struct dialogue* dialogue) {
  return dialogue->send(dialogue->context, &dialogue->reply);
}

bool link_refuse(struct dialogue* dialogue, uint32_t request_id, lamella_v1_Refusal_Code code,
                 const char* reason) {
  lamella_v1_Refusal* refusal =
      &link_begin(dialogue, request_id, lamella_v1_Reply_refusal_tag)->body.refusal;
  refusal->code = code;
  snprintf(refusal->reason, sizeof refusal->reason, "%s", reason);
  return link_send(dialogue);
}

static bool refuse_status(struct dialogue* dialogue, uint32_t id, enum lam_status status) {
  lamella_v1_Refusal_Code code = CODE(WRONG_STATE);
  if (status == LAM_UNSAFE) code = CODE(UNSAFE);
  if (status == LAM_STORE_FULL) code = CODE(STORE_FULL);
  if (status == LAM_HARDWARE) code = CODE(RIG_FAULT);
  return link_refuse(dialogue, id, code, dialogue->session->refusal);
}

static void tell_unfit(const struct selftest* test, lamella_v1_Status* status) {
  for (int i = 0; i < SELFTEST_PARTS; i++) {
    if (!(test->unfit >> i & 1)) continue;
    snprintf(status->unfit[status->unfit_count++], sizeof status->unfit[0], "%s: %s",
             selftest_part_name((enum selftest_part)i), test->why[i]);
  }
}

static bool send_status(struct dialogue* dialogue, uint32_t id) {
  lamella_v1_Reply* reply = link_begin(dialogue, id, lamella_v1_Reply_status_tag);
  session_status(dialogue->session, &reply->body.status);
  if (dialogue->alone != NULL) tell_unfit(dialogue->alone->selftest, &reply->body.status);
  return link_send(dialogue);
}

// A wrong version is answered, then the connection closed: nothing later can be understood.
static bool answer_hello(struct dialogue* dialogue, uint32_t id, const lamella_v1_Hello* hello) {
  if (hello->protocol_version != LINK_PROTOCOL_VERSION) {
    link_refuse(dialogue, id, CODE(VERSION), "this rig speaks protocol version 1");
    return false;
  }
  dialogue->greeted = true;
  lamella_v1_Welcome* welcome =
      &link_begin(dialogue, id, lamella_v1_Reply_welcome_tag)->body.welcome;
  welcome->protocol_version = LINK_PROTOCOL_VERSION;
  snprintf(welcome->firmware_version, sizeof welcome->firmware_version, LINK_FIRMWARE_VERSION);
  snprintf(welcome->hal, sizeof welcome->hal, "%s", dialogue->session->hal->name);
  welcome->led_count = (uint32_t)dialogue->session->rig->led_count;
  welcome->camera_count = 2;
  const struct rig* rig = dialogue->session->rig;
  welcome->has_patterns = true;
  pattern_describe(rig, &welcome->patterns);
  welcome->projector_width = (uint32_t)rig->projector_width_px;
  welcome->projector_height = (uint32_t)rig->projector_height_px;
  return link_send(dialogue);
}

static bool answer_burst(struct dialogue* dialogue, uint32_t id,
                         const lamella_v1_BurstRequest* request) {
  struct session* session = dialogue->session;
  if (!utf8_is_valid(request->subject)) {
    return link_refuse(dialogue, id, CODE(BAD_REQUEST), "the subject's name is not UTF-8");
  }
  session->flashing_unconfirmed = !request->flashing_confirmed;
  session->subject = request->subject;
  const enum lam_status status = session_request_burst(session, request->discard_held);
  session->subject = NULL;  // the request goes; what is begun has the name
  if (status != LAM_OK) return refuse_status(dialogue, id, status);
  if (request->ends_with_host) session_tie_to_host(session);
  lamella_v1_BurstAccepted* accepted =
      &link_begin(dialogue, id, lamella_v1_Reply_accepted_tag)->body.accepted;
  accepted->burst_id = session->burst_id;
  accepted->step_count = (uint32_t)session_plan(session)->count;
  accepted->planned_us = session_plan(session)->duration_us;
  return link_send(dialogue);
}

// One that is asked again, as its answer was lost, is over: what runs now is something newer.
static bool answer_abort(struct dialogue* dialogue, uint32_t id, const lamella_v1_Abort* abort) {
  if (abort->attempt != 0 && abort->attempt == dialogue->aborted) return send_status(dialogue, id);
  const enum lam_status status = session_abort(dialogue->session);
  if (status != LAM_OK) return refuse_status(dialogue, id, status);
  dialogue->aborted = abort->attempt;
  return send_status(dialogue, id);
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
      return answer_abort(dialogue, id, &request->body.abort);
    case lamella_v1_Request_blob_tag:
      return link_answer_blob(dialogue, id, &request->body.blob);
    case lamella_v1_Request_ack_tag:
      return link_answer_ack(dialogue, id, &request->body.ack);
    case lamella_v1_Request_timing_tag:
      return link_answer_timing(dialogue, id, &request->body.timing);
    case lamella_v1_Request_frames_tag:
      return link_answer_frames(dialogue, id, request->body.frames.burst_id);
    case lamella_v1_Request_bursts_tag:
      return link_answer_bursts(dialogue, id);
    case lamella_v1_Request_burst_ack_tag:
      return link_answer_burst_ack(dialogue, id, request->body.burst_ack.burst_id);
    case lamella_v1_Request_selftest_tag:
      return link_answer_selftest(dialogue, id, &request->body.selftest);
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
  session_hear_host(dialogue->session);
  return answer_request(dialogue, &request);
}

bool link_tell_news(struct dialogue* dialogue) {
  struct session* session = dialogue->session;
  const bool news = session->has_news, progress = session->has_progress;
  if (!dialogue->greeted || (!news && !progress)) return true;
  session->has_news = session->has_progress = false;
  const bool over = news && session->state == lamella_v1_RigState_IDLE;
  if (!over) return send_status(dialogue, 0);
  link_begin(dialogue, 0, lamella_v1_Reply_done_tag)->body.done = session->done;
  return link_send(dialogue);
}
