// lamella-rigd: the rig's daemon. Exit 0 stopped, 2 bad input, 3 rig or link failed.
#include <errno.h>
#include <pb_encode.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "arguments.h"
#include "calibration.h"
#include "complain.h"
#include "hal_linux.h"
#include "hal_sim.h"
#include "input_file.h"
#include "link.h"
#include "link_announce.h"
#include "plan.h"
#include "rig.h"
#include "selftest.h"
#include "session.h"
#include "standalone.h"
#include "store.h"
#include "supervise.h"
#include "supervise_notify.h"

enum { kExitBadInput = 2, kExitRigFailed = 3, kMaxCalibrationBytes = 1 << 20 };

static volatile sig_atomic_t stop;

static void on_signal(int number) {
  (void)number;
  stop = 1;
}

static const int kEndings[] = {SIGTERM, SIGINT, SIGHUP};
enum { kEndingCount = sizeof kEndings / sizeof kEndings[0] };

// They are held until the serving loop has time for them (link.h): then they end its wait. One that
// was ignored before, as by nohup, stays so.
static void catch_signals(void) {
  const struct sigaction action = {.sa_handler = on_signal};
  sigset_t held;
  sigemptyset(&held);
  for (int i = 0; i < kEndingCount; i++) {
    struct sigaction before;
    sigaction(kEndings[i], NULL, &before);
    if (before.sa_handler == SIG_IGN) continue;
    sigaddset(&held, kEndings[i]);
    sigaction(kEndings[i], &action, NULL);
  }
  sigprocmask(SIG_BLOCK, &held, NULL);
}

static bool is_asked_to_stop(void) {
  sigset_t held;
  if (sigpending(&held) != 0) return false;
  for (int i = 0; i < kEndingCount; i++) {
    if (sigismember(&held, kEndings[i])) return true;
  }
  return false;
}

static int explain(enum lam_status status, const char* error) {
  complain("lamella-rigd: %s", error);
  return status == LAM_BAD_INPUT ? kExitBadInput : kExitRigFailed;
}

// Everything that the daemon keeps for as long as it runs; nothing is allocated later.
struct daemon {
  struct rig rig;
  struct hal* hal;
  union {
    struct hal_sim sim;
    struct hal_linux board;
  };
  struct store store;
  struct session session;
  struct selftest selftest;
  struct selftest_disk disk;
  struct standalone alone;
  struct link_server server;
};

static enum lam_status start_store(struct daemon* daemon, const char* folder, char* error,
                                   size_t error_size) {
  const struct dialogue* dialogue = &daemon->server.dialogue;
  const size_t capacity = (size_t)daemon->rig.store_capacity_bytes;
  uint8_t* block = malloc(capacity);
  if (block == NULL) {
    snprintf(error, error_size, "store.capacity_bytes is more than there is");
    return LAM_BAD_INPUT;
  }
  store_init(&daemon->store, block, capacity);
  if (daemon->rig.board.given) daemon->store.avoid_cpu = (int)daemon->rig.board.cpu;
  if (folder == NULL) return LAM_OK;
  return store_open(&daemon->store, folder, dialogue->calibration, dialogue->calibration_size,
                    error, error_size);
}

static enum lam_status open_hal(struct daemon* daemon, const struct arguments* arguments) {
  if (strcmp(arguments->hal, "linux") == 0) return hal_linux_open(&daemon->board);
  daemon->hal = &daemon->sim.hal;
  struct hal_sim* sim = &daemon->sim;
  const enum lam_status status =
      hal_sim_open(sim, &daemon->rig, arguments->clock, arguments->faults, arguments->twin);
  if (status != LAM_OK || !arguments->test_frames) return status;
  return hal_sim_use_test_frames(sim);
}

static void darken(void* board) { hal_linux_darken(board); }

static bool is_lit(void* board) { return hal_linux_is_lit(board); }

// The lights' lines are taken, and dark, before there are two processes to hold them. 0 in the
// sequencer, or an exit code; the supervisor does not come back.
static int claim_lights(struct daemon* daemon) {
  daemon->hal = &daemon->board.hal;
  const enum lam_status status = hal_linux_claim(&daemon->board, &daemon->rig);
  if (status != LAM_OK) return explain(status, daemon->hal->error);
  const int priority = (int)daemon->rig.board.priority;
  const struct supervised supervised = {
      .context = &daemon->board,
      .lights_off = darken,
      .is_lit = is_lit,
      .priority = priority < 99 ? priority + 1 : priority,  // it sleeps but for its one task
  };
  if (supervise_fork(&supervised, kExitRigFailed) == 0) return 0;
  return explain(LAM_HARDWARE, "there can be no supervisor for the sequencer");
}

// The cameras whose photographs the rig takes; NULL where they are a twin's, as large as it likes.
// Of no hardware it is only asked what the rig file is good for.
static const struct rig_camera* own_cameras(const struct daemon* daemon,
                                            const struct arguments* arguments) {
  const bool own =
      arguments->hal == NULL || strcmp(arguments->hal, "linux") == 0 || arguments->test_frames;
  return own && daemon->rig.sensor.width_px > 0 ? &daemon->rig.sensor : NULL;
}

// Into memory that lives as long as the daemon.
static enum lam_status read_calibration(struct dialogue* dialogue, const char* path,
                                        const struct rig* rig, const struct rig_camera* cameras) {
  static uint8_t bytes[kMaxCalibrationBytes];
  char unread[INPUT_FILE_WHY_CHARS], why[CALIBRATION_WHY_CHARS];
  size_t* size = &dialogue->calibration_size;
  if (!input_file_read(path, bytes, sizeof bytes, size, unread)) {
    complain("lamella-rigd: --calibration %s: %s", path, unread);
    return LAM_BAD_INPUT;
  }
  if (!calibration_check((const char*)bytes, *size, rig, cameras, why)) {
    complain("lamella-rigd: --calibration %s: %s", path, why);
    return LAM_BAD_INPUT;
  }
  dialogue->calibration = bytes;
  return LAM_OK;
}

// A rig file may be checked on another computer than the rig's: there it is no more than a remark.
static bool has_cpu(const struct rig* rig) {
  const long count = sysconf(_SC_NPROCESSORS_CONF);
  if (!rig->board.given || rig->board.cpu < (double)count) return true;
  complain("lamella-rigd: linux.cpu is %.0f: this computer has processors 0 to %ld", rig->board.cpu,
           count - 1);
  return false;
}

static enum lam_status read_rig(struct daemon* daemon, const struct arguments* arguments) {
  char error[160];
  if (rig_read(arguments->rig, &daemon->rig) != LAM_OK) return LAM_BAD_INPUT;
  if (sim_faults_fit(&arguments->faults, &daemon->rig, error)) return LAM_OK;
  explain(LAM_BAD_INPUT, error);
  return LAM_BAD_INPUT;
}

// What can be told without the hardware is told before any of it is touched.
static enum lam_status read_inputs(struct daemon* daemon, const struct arguments* arguments) {
  if (read_rig(daemon, arguments) != LAM_OK) return LAM_BAD_INPUT;
  if (strcmp(arguments->hal, "linux") != 0) return LAM_OK;
  if (!has_cpu(&daemon->rig)) return LAM_BAD_INPUT;
  if (arguments->state == NULL) {
    complain(
        "lamella-rigd: no --state: whoever can log in here may light the LEDs, over loopback "
        "in the clear");
  }
  return LAM_OK;
}

// 0, or an exit code.
static int start(struct daemon* daemon, const struct arguments* arguments) {
  char error[LINK_FILE_PATH_CHARS + 160];
  struct dialogue given = {0};
  if (read_inputs(daemon, arguments) != LAM_OK) return kExitBadInput;
  const struct rig_camera* cameras = own_cameras(daemon, arguments);
  if (read_calibration(&given, arguments->calibration, &daemon->rig, cameras) != LAM_OK) {
    return kExitBadInput;
  }
  const bool real = strcmp(arguments->hal, "linux") == 0;
  const int unclaimed = real ? claim_lights(daemon) : 0;
  if (unclaimed != 0) return unclaimed;
  struct link_server* server = &daemon->server;
  const struct link_place place = {arguments->listen, arguments->state, arguments->name};
  enum lam_status status = link_listen(server, &place, error, sizeof error);
  if (status != LAM_OK) return explain(status, error);
  server->dialogue.calibration = given.calibration;
  server->dialogue.calibration_size = given.calibration_size;
  status = start_store(daemon, arguments->store, error, sizeof error);
  if (status != LAM_OK) return explain(status, error);
  status = open_hal(daemon, arguments);
  if (status != LAM_OK) return explain(status, daemon->hal->error);
  session_init(&daemon->session, &daemon->rig, daemon->hal, &daemon->store);
  session_test_latency(&daemon->session);
  return 0;
}

static bool code_light(void* server, bool* light) { return link_code_light(server, light); }

// The self-test's first part is over before a host is heard. The simulated rig's twin is asked for
// photographs of bursts alone, unless the rig works without a host; and how late this computer
// wakes up says nothing of a board.
static int start_panel(struct daemon* daemon, const struct arguments* arguments) {
  char error[112];
  struct selftest* selftest = &daemon->selftest;
  const bool real = strcmp(arguments->hal, "linux") == 0;
  const unsigned light = 1u << SELFTEST_CAMERAS | 1u << SELFTEST_LEDS;
  const unsigned all = SELFTEST_ALL & ~(real ? 0 : 1u << SELFTEST_LATENCY);
  selftest_init(selftest, &daemon->rig, daemon->hal, &daemon->store);
  daemon->disk = (struct selftest_disk){store_measure, &daemon->store};
  if (arguments->store != NULL) selftest->disk = &daemon->disk;
  selftest->reference_path = arguments->led_reference;
  if (arguments->led_reference != NULL &&
      led_reference_read(arguments->led_reference, daemon->rig.led_count, &selftest->reference,
                         error) != LAM_OK) {
    return explain(LAM_BAD_INPUT, error);
  }
  standalone_init(&daemon->alone, &daemon->session, selftest,
                  real || arguments->standalone ? all : all & ~light);
  daemon->alone.has_button = arguments->standalone;
  daemon->alone.code_light = code_light;
  daemon->alone.code_context = &daemon->server;
  daemon->server.tend = standalone_tend;
  daemon->server.tend_context = &daemon->alone;
  daemon->server.dialogue.alone = &daemon->alone;
  while (daemon->alone.state == STANDALONE_TESTING && !is_asked_to_stop()) {
    standalone_tend(&daemon->alone);
  }
  return 0;
}

// What was asked for went to standard output, or nowhere: then 2, as with `lamella`.
static int end_output(void) {
  if (fflush(stdout) == 0 && !ferror(stdout)) return 0;
  complain("lamella-rigd: standard output: cannot be written: %s", strerror(errno));
  return kExitBadInput;
}

// An exit code: 0 where the rig would play the burst of its rig file.
static int judge_plan(const struct rig* rig, const char* rig_file) {
  static lamella_v1_Plan plan;
  if (plan_describe(rig, &plan) == LAM_OK) return 0;
  complain("%s: the rig would not play its burst: %s", rig_file, plan.refusal);
  return kExitBadInput;
}

// A plan that the rig would not play is written too, with the reason in it.
static int write_plan(const struct rig* rig) {
  static lamella_v1_Plan plan;
  static uint8_t bytes[lamella_v1_Plan_size];
  plan_describe(rig, &plan);
  pb_ostream_t stream = pb_ostream_from_buffer(bytes, sizeof bytes);
  if (!pb_encode(&stream, lamella_v1_Plan_fields, &plan)) {
    return explain(LAM_HARDWARE, "the plan cannot be encoded");
  }
  fwrite(bytes, 1, stream.bytes_written, stdout);
  return end_output();
}

static int announce(const struct arguments* arguments) {
  char error[LINK_FILE_PATH_CHARS + 160];
  const struct link_place place = {arguments->listen, arguments->state, arguments->name};
  const enum lam_status status = announce_write(arguments->announce, &place, error, sizeof error);
  return status == LAM_OK ? 0 : explain(status, error);
}

static int tell(const struct arguments* arguments) {
  if (arguments->help) fputs(kArgumentsHelp, stdout);
  if (!arguments->help) {
    printf("lamella-rigd %s (link protocol %d)\n", LINK_FIRMWARE_VERSION, LINK_PROTOCOL_VERSION);
  }
  return end_output();
}

// Whoever waits for the line would wait for ever where it is lost.
static int announce_listening(const struct daemon* daemon) {
  printf("listening on %s:%u\n", daemon->server.door.address, daemon->server.door.port);
  const int failure = end_output();
  if (failure == 0) notify_ready(kPanelTable[daemon->alone.panel.code].name);
  return failure;
}

static void stop_in_order(struct daemon* daemon) {
  notify_stopping();
  session_close(&daemon->session);  // lights off first; a burst under way ends plainly partial
  daemon->hal->close(daemon->hal->self);
  store_close(&daemon->store);
  link_close(&daemon->server);
}

// An exit code.
static int judge_files(struct daemon* daemon, const struct arguments* arguments) {
  struct dialogue unused = {0};
  if (read_rig(daemon, arguments) != LAM_OK) return kExitBadInput;
  if (arguments->check) has_cpu(&daemon->rig);
  if (arguments->calibration != NULL &&
      read_calibration(&unused, arguments->calibration, &daemon->rig,
                       own_cameras(daemon, arguments)) != LAM_OK) {
    return kExitBadInput;
  }
  return arguments->plan ? write_plan(&daemon->rig) : judge_plan(&daemon->rig, arguments->rig);
}

int main(int argc, char** argv) {
  static struct daemon daemon;
  struct arguments arguments;
  if (!arguments_parse(argc, argv, &arguments)) return kExitBadInput;
  if (arguments.help || arguments.version) return tell(&arguments);
  if (arguments.announce != NULL) return announce(&arguments);
  if (arguments.check || arguments.plan) return judge_files(&daemon, &arguments);
  catch_signals();
  int failure = start(&daemon, &arguments);
  if (failure == 0) failure = start_panel(&daemon, &arguments);
  if (failure != 0) return failure;
  failure = announce_listening(&daemon);
  if (failure == 0) link_serve(&daemon.server, &daemon.session, &stop);
  stop_in_order(&daemon);
  return failure;
}
