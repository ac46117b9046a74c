#include "arguments.h"

#include <getopt.h>
#include <stdio.h>
#include <string.h>

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
    "  --standalone           the START button takes bursts\n"
    "  --led-reference FILE   what the self-test compares LEDs with\n"
    "  --name NAME            of the rig; else the machine's\n"
    "  --clock virtual|real   of the simulated rig\n"
    "  --test-frames          photographs of noise, as big as the rig file's cameras\n"
    "                         send, and read while the burst is played; no twin\n"
    "  --inject FAULT         into the simulated rig; N, M count from 0:\n" SIM_FAULT_NAMES
    "exit: 0 stopped (SIGTERM, SIGINT, SIGHUP), 2 bad input, 3 rig or link failed\n";

static const char kSeeHelp[] = "see lamella-rigd --help";

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
