// LinkClient's way to a rig: connected, in TLS or in the clear, and greeted.
#include "base/error.h"
#include "io/link_client.h"

namespace lamella {

namespace {

constexpr char kBusy[] = "busy with another host";

}  // namespace

LinkClient::LinkClient(std::string address, LinkOptions options)
    : address_(std::move(address)), options_(std::move(options)) {
  if (const auto fault = address_fault(address_)) throw_bad_input("rig", *fault);
  socket_.set_interrupted(options_.interrupted);
  if (const Break broken = connect()) fail_to_connect(*broken);
}

void LinkClient::fail(const std::string& problem, const std::string& remedy) const {
  if (options_.interrupted && options_.interrupted()) {
    if (!options_.outlives_us) {
      throw Error(Fault::kRig, "rig " + address_, "interrupted, nothing was kept");
    }
    if (!options_.once_interrupted.empty()) {
      throw Error(Fault::kRig, "rig " + address_, "interrupted; " + options_.once_interrupted);
    }
    throw Error(Fault::kRig, "rig " + address_, "interrupted; what the rig holds stays there",
                "lamella rig sync --rig " + address_ + " --out FOLDER fetches it, or goes on");
  }
  throw Error(Fault::kRig, "rig " + address_, problem, remedy);
}

// Who answers is there, whatever it said: only silence is "no rig answers".
void LinkClient::fail_to_connect(const std::string& broken) const {
  const std::string pair = "lamella rig pair --rig " + address_;
  if (broken == kNoSuchHost) throw_bad_input("rig " + address_, broken, "is its name mistyped?");
  if (broken == kBusy)
    fail(broken, "it serves one host at a time: try again when that one is done");
  if (broken == kAnswersInTls || broken == kNotPaired) {
    fail(broken, "hold its START button and run: " + pair);
  }
  if (broken == kAnotherKey) {
    fail(broken, "if its key was made anew, hold its START button and run: " + pair);
  }
  if (broken == kAnswersInTheClear) {
    fail(broken, "start its lamella-rigd with --state, or undo the pairing: " + pair + " --forget");
  }
  const bool nobody = !reached_;
  const std::string running =
      options_.tls ? "is lamella-rigd running there, and paired with this host? " + pair
                   : "is lamella-rigd running there?";
  const std::string starting =
      "; a rig that starts first tests itself for some seconds: try again then";
  fail((nobody ? "no rig answers (" : "something answers, but not as a rig (") + broken + ")",
       running + (nobody ? "" : starting));
}

Break LinkClient::connect() {
  socket_.close();
  reached_ = false;
  const Deadline end = deadline_in(options_.connect_s);
  if (Break broken = socket_.connect_tcp(address_, end)) return broken;
  reached_ = true;
  if (options_.tls) {
    if (Break broken = socket_.start_tls(*options_.tls, end)) return broken;
  }
  return greet();
}

Break LinkClient::greet() {
  v1::Request request;
  request.mutable_hello()->set_protocol_version(kProtocolVersion);
  request.mutable_hello()->set_host_name("lamella");
  request.set_request_id(++request_id_);
  if (Break broken = socket_.send(request, deadline_in(options_.reply_s))) return broken;
  v1::Reply reply;
  do {  // an event may come first
    if (Break broken = socket_.receive(&reply, deadline_in(options_.reply_s))) return broken;
  } while (reply.has_status() || reply.has_done());
  // The rig may not have noticed yet that our last connection is gone.
  if (reply.refusal().code() == v1::Refusal::WRONG_STATE) return kBusy;
  throw_refusal(reply);
  if (!reply.has_welcome()) return "did not answer the greeting";
  welcome_ = reply.welcome();
  if (welcome_.protocol_version() != kProtocolVersion) {
    fail("speaks protocol version " + std::to_string(welcome_.protocol_version()) + ", this host " +
             std::to_string(kProtocolVersion),
         "update whichever is older");
  }
  return {};
}

}  // namespace lamella
