// Where a command that reads a fitted session may write: never over what it reads.
#pragma once

#include "io/whole_file.h"

namespace lamella::apps {

struct FittedInput {
  fs::path session, fit;
  fs::path view;  // empty: none is read
};

// Throws Error where `out` is named as if it were of another kind than `ending`, ".png"; where no
// file can be put at it, or one of `input` is there, or it would be among
// the session's photographs. Also removes what killed runs left beside it.
void prepare_output(const fs::path& out, const std::string& ending, const FittedInput& input);

}  // namespace lamella::apps
