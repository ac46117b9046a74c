// The subcommands of `lamella`. Each adds itself to the parser and, when chosen, sets the exit
// code:
// 0 done, 1 done but below the quality asked, 2 bad input, 3 rig or link failed.
#pragma once

#include <CLI/CLI.hpp>

namespace lamella::apps {

void add_capture(CLI::App& app, int* exit_code);
void add_twin(CLI::App& app, int* exit_code);
void add_check(CLI::App& app, int* exit_code);
void add_fit(CLI::App& app, int* exit_code);
void add_render(CLI::App& app, int* exit_code);
void add_compare(CLI::App& app, int* exit_code);
void add_export(CLI::App& app, int* exit_code);
void add_rig(CLI::App& app, int* exit_code);
// Parts of the one above.
void add_rig_pair(CLI::App* rig, int* exit_code);
void add_rig_list(CLI::App* rig, int* exit_code);
void add_rig_selftest(CLI::App* rig, int* exit_code);
void add_rig_bursts(CLI::App* rig, int* exit_code);

// HOST:PORT of the one paired rig on this network. Throws Error (kRig) where there is not one.
std::string the_paired_rig();

void add_review(CLI::App& app, int* exit_code);

}  // namespace lamella::apps
