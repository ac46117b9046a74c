#include "arguments.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

#include "complain.h"

const char kArgumentsHelp[] =
    "usage: lamella-rigd --hal linux --rig FILE --calibration FILE\n"
    "                    --listen ADDRESS:PORT --state FOLDER [OPTION]...\n"
    "       lamella-rigd --hal sim --rig FILE --calibration FILE\n"
    "                    --listen 127.0.0.1:PORT --twin SOCKET|--test-frames\n"
    "                    [OPTION]...\n"
    "       lamella-rigd --check --rig FILE [--calibration FILE]  what is wrong\n"
    "       lamella-rigd --plan --rig FILE    its burst, a lamella.v1.Plan, on stdout\n"
    "       lamella-rigd --announce FILE --state FOLDER --listen ADDRESS:PORT\n"
    "       lamella-rigd --help | --version\n"
    "  --state FOLDER         the rig's key and paired hosts, for TLS; without it\n"
    "                         the link is in the clear, on loopback alone\n"
    "  --store FOLDER         keeps photographs on disk until a host has them\n"
    "  --standalone           the START button takes bursts; needs --store\n"
    "  --led-reference FILE   what the self-test compares LEDs with\n"
    "  --name NAME            of the rig; else the machine's\n"
    "  --clock virtual|real   of the simulated rig\n"
    "  --test-frames          photographs of noise, as big as the rig file's cameras\n"
    "                         send, and read while the burst is played; no twin\n"
    "  --inject FAULT         into the simulated rig; N, M count from 0:\n" SIM_FAULT_NAMES
    "exit: 0 stopped (SIGTERM, SIGINT, SIGHUP), 2 bad input, 3 rig or link failed\n";

static const char kSeeHelp[] = "see lamella-rigd --help";
static const char kNeedsValue[] = "needs a value";

static bool parse_clock(const char* text, enum sim_clock* clock) {
  *clock = strcmp(text, "real") == 0 ? SIM_CLOCK_REAL : SIM_CLOCK_VIRTUAL;
  return *clock == SIM_CLOCK_REAL || strcmp(text, "virtual") == 0;
}

static bool require(const char* value, const char* option) {
  if (value == NULL) complain("lamella-rigd: %s is missing; %s", option, kSeeHelp);
  return value != NULL;
}

static bool refuse(const char* option, const char* value, const char* why) {
  complain("lamella-rigd: %s%s%s: %s; %s", option, value[0] != '\0' ? " " : "", value, why,
           kSeeHelp);
  return false;
}

static bool is_of_one_mind(const struct arguments* arguments) {
  if (arguments->test_frames && arguments->twin != NULL) {
    return refuse("--test-frames", "", "not with --twin: leave out one of them");
  }
  // Each of these is all that the daemon then does.
  if (arguments->check && arguments->plan) return refuse("--check", "", "not with --plan");
  if (arguments->announce == NULL || !(arguments->check || arguments->plan)) return true;
  return refuse("--announce", "", arguments->check ? "not with --check" : "not with --plan");
}

static bool is_complete(const struct arguments* arguments) {
  if (arguments->help || arguments->version) return true;
  if (!is_of_one_mind(arguments)) return false;
  if (arguments->announce != NULL) {
    return require(arguments->state, "--state") && require(arguments->listen, "--listen");
  }
  if (arguments->check || arguments->plan) return require(arguments->rig, "--rig");
  if (!require(arguments->hal, "--hal") || !require(arguments->rig, "--rig") ||
      !require(arguments->calibration, "--calibration") ||
      !require(arguments->listen, "--listen")) {
    return false;
  }
  if (arguments->standalone && arguments->store == NULL) {
    return refuse("--standalone", "", "needs --store: no host takes its photographs away");
  }
  if (strcmp(arguments->hal, "linux") == 0) return true;
  if (strcmp(arguments->hal, "sim") == 0) {
    return arguments->test_frames || require(arguments->twin, "--twin");
  }
  complain("lamella-rigd: --hal %s: there are sim and linux", arguments->hal);
  return false;
}

static bool refuse_fault(const char* fault) {
  char why[160];
  sim_faults_explain(fault, why);
  return refuse("--inject", fault, why);
}

static bool take_fault(struct arguments* arguments) {
  if (!sim_faults_parse(optarg, &arguments->faults)) return refuse_fault(optarg);
  const unsigned kind = 1u << sim_faults_kind(optarg);
  if ((arguments->fault_kinds & kind) != 0) {
    return refuse("--inject", optarg, "one of its kind is given already");
  }
  arguments->fault_kinds |= kind;
  return true;
}

static bool* flag_of(struct arguments* arguments, int option) {
  switch (option) {
    case 'f':
      return &arguments->test_frames;
    case 'x':
      return &arguments->check;
    case 'p':
      return &arguments->plan;
    case 'a':
      return &arguments->standalone;
    case 'H':
      return &arguments->help;
    case 'V':
      return &arguments->version;
    default:
      return NULL;
  }
}

static const char** text_of(struct arguments* arguments, int option) {
  switch (option) {
    case 'h':
      return &arguments->hal;
    case 'r':
      return &arguments->rig;
    case 't':
      return &arguments->twin;
    case 'c':
      return &arguments->calibration;
    case 'l':
      return &arguments->listen;
    case 'k':
      return &arguments->clock_name;
    case 's':
      return &arguments->store;
    case 'S':
      return &arguments->state;
    case 'n':
      return &arguments->name;
    case 'e':
      return &arguments->led_reference;
    case 'A':
      return &arguments->announce;
    default:
      return NULL;
  }
}

static bool take(struct arguments* arguments, const struct option* option) {
  char name[32];
  snprintf(name, sizeof name, "--%s", option->name);
  bool* flag = flag_of(arguments, option->val);
  const char** text = text_of(arguments, option->val);
  if (flag != NULL) {
    *flag = true;
  } else if (optarg[0] == '\0') {
    return refuse(name, "", kNeedsValue);
  } else if (text == NULL) {
    return take_fault(arguments);
  } else if (*text != NULL) {
    return refuse(name, optarg, "given twice");
  } else {
    *text = optarg;
  }
  return true;
}

bool arguments_parse(int argc, char** argv, struct arguments* arguments) {
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
  int index = 0;
  for (int option; (option = getopt_long(argc, argv, ":", kOptions, &index)) != -1;) {
    if (option == '?') return refuse(argv[optind - 1], "", "no such option");
    if (option == ':') return refuse(argv[optind - 1], "", kNeedsValue);
    if (!take(arguments, &kOptions[index])) return false;
  }
  if (optind < argc) return refuse(argv[optind], "", "is no option");
  if (arguments->clock_name != NULL && !parse_clock(arguments->clock_name, &arguments->clock)) {
    return refuse("--clock", arguments->clock_name, "there are virtual and real");
  }
  return is_complete(arguments);
}
