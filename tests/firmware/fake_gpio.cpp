#include "fake_gpio.h"

#include <gpiod.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <set>

namespace {

FakeGpio chip;

// A line is the address of its own name.
const std::string& name_of(struct gpiod_line* line) {
  return *reinterpret_cast<const std::string*>(line);
}

std::vector<std::string> names_of(struct gpiod_line_bulk* bulk) {
  std::vector<std::string> names;
  for (unsigned i = 0; i < gpiod_line_bulk_num_lines(bulk); i++) {
    names.push_back(name_of(gpiod_line_bulk_get_line(bulk, i)));
  }
  return names;
}

int drive(struct gpiod_line* line, int level) {
  chip.levels[name_of(line)] = level;
  chip.driven.emplace_back(name_of(line), level);
  return 0;
}

}  // namespace

FakeGpio& fake_gpio() { return chip; }

bool fake_gpio_fails() {
  errno = EIO;
  return chip.calls++ == chip.failing_call;
}

extern "C" {
struct gpiod_chip* gpiod_chip_open(const char* path) {
  if (fake_gpio_fails()) return nullptr;
  errno = ENOENT;
  if (std::strcmp(path, "/dev/gpiochip0") != 0) return nullptr;
  chip.opened++;
  return reinterpret_cast<gpiod_chip*>(&chip);
}

void gpiod_chip_close(struct gpiod_chip*) { chip.closed++; }

struct gpiod_line* gpiod_chip_find_line(struct gpiod_chip*, const char* name) {
  static std::set<std::string> names;
  if (fake_gpio_fails()) return nullptr;
  errno = ENOENT;
  if (name == chip.unknown_line) return nullptr;
  chip.asked.emplace_back(name);
  return reinterpret_cast<gpiod_line*>(const_cast<std::string*>(&*names.insert(name).first));
}

int gpiod_line_request_output(struct gpiod_line* line, const char*, int level) {
  if (fake_gpio_fails()) return -1;
  errno = EBUSY;
  if (chip.busy) return -1;
  chip.held.insert(name_of(line));
  return drive(line, level);
}

int gpiod_line_set_value(struct gpiod_line* line, int level) {
  if (fake_gpio_fails()) return -1;
  return chip.broken ? -1 : drive(line, level);
}

int gpiod_line_request_bulk_both_edges_events(struct gpiod_line_bulk* bulk, const char*) {
  if (fake_gpio_fails()) return -1;
  errno = EBUSY;
  if (chip.busy) return -1;
  for (const std::string& name : names_of(bulk)) chip.held.insert(name);
  return 0;
}

int gpiod_line_get_value(struct gpiod_line* line) {
  if (fake_gpio_fails() || chip.deaf) return -1;
  return chip.levels[name_of(line)];
}

int gpiod_line_event_wait_bulk(struct gpiod_line_bulk* bulk, const struct timespec*,
                               struct gpiod_line_bulk* ready) {
  if (fake_gpio_fails() || chip.deaf) return -1;
  for (unsigned i = 0; i < gpiod_line_bulk_num_lines(bulk); i++) {
    struct gpiod_line* line = gpiod_line_bulk_get_line(bulk, i);
    if (chip.edges.empty() || name_of(line) != chip.edges.front().line) continue;
    gpiod_line_bulk_init(ready);
    gpiod_line_bulk_add(ready, line);
    return 1;
  }
  return 0;
}

int gpiod_line_event_read(struct gpiod_line*, struct gpiod_line_event* event) {
  if (fake_gpio_fails()) return -1;
  const FakeGpio::Edge edge = chip.edges.front();
  chip.edges.pop_front();
  chip.levels[edge.line] = edge.level;
  event->event_type = edge.level ? GPIOD_LINE_EVENT_RISING_EDGE : GPIOD_LINE_EVENT_FALLING_EDGE;
  event->ts.tv_sec = time_t(edge.at_us / 1e6);
  event->ts.tv_nsec = long(std::fmod(edge.at_us, 1e6) * 1e3);
  return 0;
}

void gpiod_line_release_bulk(struct gpiod_line_bulk* bulk) {
  for (const std::string& name : names_of(bulk)) chip.held.erase(name);
}
}
