// A GPIO chip of libgpiod 1.6, played here: it remembers what it was told and has the levels and
// the edges that a test gives it.
#pragma once

#include <deque>
#include <map>
#include <set>
#include <string>
#include <utility>
#include <vector>

struct FakeGpio {
  struct Edge {
    std::string line;
    bool level;
    double at_us;
  };
  std::map<std::string, int> levels;                // of every line, driven or pulled
  std::vector<std::string> asked;                   // lines looked for, in order
  std::vector<std::pair<std::string, int>> driven;  // each line that was set, or requested with it
  std::multiset<std::string> held;                  // lines that were requested and not released
  std::deque<Edge> edges;                           // not yet read
  int opened = 0, closed = 0;
  int calls = 0, failing_call = -1;  // counts every call that may fail; this one does
  std::string unknown_line;
  bool busy = false, broken = false, deaf = false;
};

// Counts a call; true where it is the one that fails, with errno EIO.
bool fake_gpio_fails();

// The chip of the test that runs; /dev/gpiochip0.
FakeGpio& fake_gpio();
