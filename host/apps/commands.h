// The subcommands of `lamella`. Each adds itself to the parser and, when chosen, sets the exit
// code:
// 0 done, 1 done but below the quality asked, 2 bad input, 3 rig or link failed.
#pragma once

#include <string>

#include "apps/command_line.h"

namespace lamella::apps {

void add_capture(const Command& app, int* exit_code);
void add_twin(const Command& app, int* exit_code);
void add_check(const Command& app, int* exit_code);
void add_fit(const Command& app, int* exit_code);
void add_bench(const Command& app, int* exit_code);
void add_render(const Command& app, int* exit_code);
void add_compare(const Command& app, int* exit_code);
void add_export(const Command& app, int* exit_code);
void add_rig(const Command& app, int* exit_code);
// Parts of the one above.
void add_rig_pair(const Command& rig, int* exit_code);
void add_rig_list(const Command& rig, int* exit_code);
void add_rig_selftest(const Command& rig, int* exit_code);
void add_rig_bursts(const Command& rig, int* exit_code);

// HOST:PORT of the one paired rig on this network. Throws Error (kRig) where there is not one.
std::string the_paired_rig();

void add_review(const Command& app, int* exit_code);

}  // namespace lamella::apps
