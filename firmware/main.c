// lamella-rigd: the rig's daemon. Exit 0 stopped, 2 bad input, 3 rig or link failed.
#include <errno.h>
#include <getopt.h>
#include <pb_encode.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "calibration.h"
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

static const char kHelp[] =
    "usage: lamella-rigd --hal linux --rig FILE --calibration FILE\n"
    "                    --listen ADDRESS:PORT --state FOLDER [OPTION]...\n"
    "       lamella-rigd --hal sim --rig FILE --calibration FILE\n"
    "                    --listen 127.0.0.1:PORT --twin SOCKET|--test-frames\n"
    "                    [OPTION]...\n"
    "       lamella-rigd --check --rig FILE   says all that is wrong with it\n"
    "       lamella-rigd --plan --rig FILE    its burst, a lamella.v1.Plan, on stdout\n"
    "       lamella-rigd --announce FILE --state FOLDER --listen ADDRESS:PORT\n"
    "       lamella-rigd --help | --version\n"
    "  --state FOLDER         the rig's key and paired hosts, for TLS; without it\n"
    "                         the link is in the clear, on loopback alone\n"
    "  --store FOLDER         keeps photographs on disk until a host has them\n"
    "  --standalone           the START button takes bursts\n"
    "  --led-reference FILE   what the self-test compares LEDs with\n"
    "  --name NAME            of the rig; else the machine's\n"
    "  --clock virtual|real   of the simulated rig\n"
    "  --test-frames          photographs of noise, as big as the rig file's cameras\n"
    "                         send, and read while the burst is played; no twin\n"
    "  --inject FAULT         into the simulated rig; N, M count from 0:\n" SIM_FAULT_NAMES
    "exit: 0 stopped (SIGTERM, SIGINT, SIGHUP), 2 bad input, 3 rig or link failed\n";

static const char kSeeHelp[] = "see lamella-rigd --help";

struct arguments {
  const char *hal, *rig, *twin, *calibration, *listen;
  const char *state, *name;   // of the link: see link_place
  const char* announce;       // write this file for Avahi, and end
  const char* store;          // NULL: photographs are kept in memory alone
  const char* led_reference;  // NULL: a reference that is learned is not kept
  bool standalone;            // the button starts bursts
  bool test_frames;           // in place of a twin's photographs
  enum sim_clock clock;
  struct sim_faults faults;
  bool check;  // read the rig file, say all that is wrong with it, and end
  bool plan;   // the same, and write the burst that it would play
  bool help, version;
};

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

static bool parse_clock(const char* text, enum sim_clock* clock) {
  *clock = strcmp(text, "real") == 0 ? SIM_CLOCK_REAL : SIM_CLOCK_VIRTUAL;
  return *clock == SIM_CLOCK_REAL || strcmp(text, "virtual") == 0;
}

static bool require(const char* value, const char* option) {
  if (value == NULL) fprintf(stderr, "lamella-rigd: %s is missing; %s\n", option, kSeeHelp);
  return value != NULL;
}

static bool is_complete(const struct arguments* arguments) {
  if (arguments->help || arguments->version) return true;
  if (arguments->announce != NULL) {
    return require(arguments->state, "--state") && require(arguments->listen, "--listen");
  }
  if (arguments->check || arguments->plan) return require(arguments->rig, "--rig");
  if (!require(arguments->hal, "--hal") || !require(arguments->rig, "--rig") ||
      !require(arguments->calibration, "--calibration") ||
      !require(arguments->listen, "--listen")) {
    return false;
  }
  if (strcmp(arguments->hal, "linux") == 0) return true;
  if (strcmp(arguments->hal, "sim") == 0) {
    return arguments->test_frames || require(arguments->twin, "--twin");
  }
  fprintf(stderr, "lamella-rigd: --hal %s: there are sim and linux\n", arguments->hal);
  return false;
}

static bool refuse(const char* option, const char* value, const char* why) {
  fprintf(stderr, "lamella-rigd: %s%s%s: %s; %s\n", option, value[0] != '\0' ? " " : "", value, why,
          kSeeHelp);
  return false;
}

static bool refuse_fault(const char* fault) {
  char why[160];
  sim_faults_explain(fault, why);
  return refuse("--inject", fault, why);
}

static bool parse_arguments(int argc, char** argv, struct arguments* arguments) {
  static const struct option kOptions[] = {{"hal", required_argument, NULL, 'h'},
                                           {"rig", required_argument, NULL, 'r'},
                                           {"twin", required_argument, NULL, 't'},
                                           {"calibration", required_argument, NULL, 'c'},
                                           {"listen", required_argument, NULL, 'l'},
                                           {"test-frames", no_argument, NULL, 'f'},
                                           {"clock", required_argument, NULL, 'k'},
                                           {"inject", required_argument, NULL, 'i'},
                                           {"check", no_argument, NULL, 'x'},
                                           {"plan", no_argument, NULL, 'p'},
                                           {"store", required_argument, NULL, 's'},
                                           {"state", required_argument, NULL, 'S'},
                                           {"name", required_argument, NULL, 'n'},
                                           {"announce", required_argument, NULL, 'A'},
                                           {"standalone", no_argument, NULL, 'a'},
                                           {"led-reference", required_argument, NULL, 'e'},
                                           {"help", no_argument, NULL, 'H'},
                                           {"version", no_argument, NULL, 'V'},
                                           {NULL, 0, NULL, 0}};
  *arguments = (struct arguments){.faults = kSimNoFaults};
  opterr = 0;
  for (int option; (option = getopt_long(argc, argv, ":", kOptions, NULL)) != -1;) {
    if (option == '?') return refuse(argv[optind - 1], "", "no such option");
    if (option == ':') return refuse(argv[optind - 1], "", "needs a value");
    if (option == 'h') arguments->hal = optarg;
    if (option == 'r') arguments->rig = optarg;
    if (option == 't') arguments->twin = optarg;
    if (option == 'c') arguments->calibration = optarg;
    if (option == 'l') arguments->listen = optarg;
    if (option == 'k' && !parse_clock(optarg, &arguments->clock)) {
      return refuse("--clock", optarg, "there are virtual and real");
    }
    if (option == 'f') arguments->test_frames = true;
    if (option == 'x') arguments->check = true;
    if (option == 'p') arguments->plan = true;
    if (option == 's') arguments->store = optarg;
    if (option == 'S') arguments->state = optarg;
    if (option == 'n') arguments->name = optarg;
    if (option == 'a') arguments->standalone = true;
    if (option == 'e') arguments->led_reference = optarg;
    if (option == 'A') arguments->announce = optarg;
    if (option == 'H') arguments->help = true;
    if (option == 'V') arguments->version = true;
    if (option == 'i' && !sim_faults_parse(optarg, &arguments->faults)) return refuse_fault(optarg);
  }
  if (optind < argc) return refuse(argv[optind], "", "is no option");
  return is_complete(arguments);
}

static int explain(enum lam_status status, const char* error) {
  fprintf(stderr, "lamella-rigd: %s\n", error);
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
static const struct rig_camera* own_cameras(const struct daemon* daemon,
                                            const struct arguments* arguments) {
  const bool own = strcmp(arguments->hal, "linux") == 0 || arguments->test_frames;
  return own && daemon->rig.sensor.width_px > 0 ? &daemon->rig.sensor : NULL;
}

// Into memory that lives as long as the daemon.
static enum lam_status read_calibration(struct dialogue* dialogue, const char* path,
                                        const struct rig_camera* cameras) {
  static uint8_t bytes[kMaxCalibrationBytes];
  char unread[INPUT_FILE_WHY_CHARS], why[CALIBRATION_WHY_CHARS];
  size_t* size = &dialogue->calibration_size;
  if (!input_file_read(path, bytes, sizeof bytes, size, unread)) {
    fprintf(stderr, "lamella-rigd: --calibration %s: %s\n", path, unread);
    return LAM_BAD_INPUT;
  }
  if (!calibration_check((const char*)bytes, *size, cameras, why)) {
    fprintf(stderr, "lamella-rigd: --calibration %s: %s\n", path, why);
    return LAM_BAD_INPUT;
  }
  dialogue->calibration = bytes;
  return LAM_OK;
}

// A rig file may be checked on another computer than the rig's: there it is no more than a remark.
static bool has_cpu(const struct rig* rig) {
  const long count = sysconf(_SC_NPROCESSORS_CONF);
  if (!rig->board.given || rig->board.cpu < (double)count) return true;
  fprintf(stderr, "lamella-rigd: linux.cpu is %.0f: this computer has processors 0 to %ld\n",
          rig->board.cpu, count - 1);
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
    fprintf(stderr,
            "lamella-rigd: no --state: whoever can log in here may light the LEDs, over loopback "
            "in the clear\n");
  }
  return LAM_OK;
}

// 0, or an exit code.
static int start(struct daemon* daemon, const struct arguments* arguments) {
  char error[LINK_FILE_PATH_CHARS + 160];
  struct dialogue given = {0};
  if (read_inputs(daemon, arguments) != LAM_OK) return kExitBadInput;
  const struct rig_camera* cameras = own_cameras(daemon, arguments);
  if (read_calibration(&given, arguments->calibration, cameras) != LAM_OK) return kExitBadInput;
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
  fprintf(stderr, "lamella-rigd: standard output: cannot be written: %s\n", strerror(errno));
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
  if (arguments->help) fputs(kHelp, stdout);
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

int main(int argc, char** argv) {
  static struct daemon daemon;
  struct arguments arguments;
  if (!parse_arguments(argc, argv, &arguments)) return kExitBadInput;
  if (arguments.help || arguments.version) return tell(&arguments);
  if (arguments.announce != NULL) return announce(&arguments);
  if (arguments.check || arguments.plan) {
    if (read_rig(&daemon, &arguments) != LAM_OK) return kExitBadInput;
    if (arguments.check) has_cpu(&daemon.rig);
    return arguments.plan ? write_plan(&daemon.rig) : 0;
  }
  catch_signals();
  int failure = start(&daemon, &arguments);
  if (failure == 0) failure = start_panel(&daemon, &arguments);
  if (failure != 0) return failure;
  failure = announce_listening(&daemon);
  if (failure == 0) link_serve(&daemon.server, &daemon.session, &stop);
  stop_in_order(&daemon);
  return failure;
}
