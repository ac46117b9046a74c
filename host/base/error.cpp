#include "base/error.h"

namespace lamella {

namespace {

std::string one_line(const std::string& where, const std::string& problem,
                     const std::string& remedy) {
  std::string line = where.empty() ? problem : where + ": " + problem;
  if (!remedy.empty()) line += "; " + remedy;
  for (char& c : line) {
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';  // no line ends, no escapes
  }
  return line;
}

}  // namespace

Error::Error(Fault fault, const std::string& where, const std::string& problem,
             const std::string& remedy)
    : std::runtime_error(one_line(where, problem, remedy)), fault_(fault) {}

void throw_bad_input(const std::string& where, const std::string& problem,
                     const std::string& remedy) {
  throw Error(Fault::kBadInput, where, problem, remedy);
}

}  // namespace lamella
