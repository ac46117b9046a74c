// The chip of fake_gpio.h as libgpiod 2 shows it.
#include <gpiod.h>

#include <cerrno>
#include <cstring>
#include <string>
#include <vector>

#include "../fake_gpio.h"

struct gpiod_line_settings {
  gpiod_line_direction direction = GPIOD_LINE_DIRECTION_AS_IS;
  gpiod_line_value value = GPIOD_LINE_VALUE_INACTIVE;
  gpiod_line_edge edge = GPIOD_LINE_EDGE_NONE;
};
struct gpiod_line_config {
  std::vector<unsigned> offsets;
  std::vector<gpiod_line_settings> settings;
};
struct gpiod_request_config {};
struct gpiod_line_request {
  std::vector<unsigned> offsets;
  bool outputs;
};
struct gpiod_edge_event {
  unsigned offset;
  bool level;
  uint64_t at_ns;
};
struct gpiod_edge_event_buffer {
  gpiod_edge_event event;
};

namespace {

FakeGpio chip;
std::vector<std::string> names;  // by offset

int drive(unsigned offset, gpiod_line_value value) {
  const int level = value == GPIOD_LINE_VALUE_ACTIVE;
  chip.levels[names[offset]] = level;
  chip.driven.emplace_back(names[offset], level);
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

int gpiod_chip_get_line_offset_from_name(struct gpiod_chip*, const char* name) {
  if (fake_gpio_fails()) return -1;
  errno = ENOENT;
  if (name == chip.unknown_line) return -1;
  chip.asked.emplace_back(name);
  for (size_t i = 0; i < names.size(); i++) {
    if (names[i] == name) return int(i);
  }
  names.emplace_back(name);
  return int(names.size()) - 1;
}

struct gpiod_line_settings* gpiod_line_settings_new() {
  return new gpiod_line_settings;
}
void gpiod_line_settings_free(struct gpiod_line_settings* settings) { delete settings; }
int gpiod_line_settings_set_direction(struct gpiod_line_settings* s, gpiod_line_direction to) {
  s->direction = to;
  return fake_gpio_fails() ? -1 : 0;
}
int gpiod_line_settings_set_edge_detection(struct gpiod_line_settings* s, gpiod_line_edge edge) {
  s->edge = edge;
  return fake_gpio_fails() ? -1 : 0;
}
int gpiod_line_settings_set_event_clock(struct gpiod_line_settings*, gpiod_line_clock clock) {
  errno = EINVAL;
  return clock != GPIOD_LINE_CLOCK_MONOTONIC || fake_gpio_fails() ? -1 : 0;
}
int gpiod_line_settings_set_output_value(struct gpiod_line_settings* s, gpiod_line_value value) {
  s->value = value;
  return fake_gpio_fails() ? -1 : 0;
}

struct gpiod_line_config* gpiod_line_config_new() {
  return new gpiod_line_config;
}
void gpiod_line_config_free(struct gpiod_line_config* config) { delete config; }
int gpiod_line_config_add_line_settings(struct gpiod_line_config* config, const unsigned* offsets,
                                        size_t count, struct gpiod_line_settings* settings) {
  if (fake_gpio_fails()) return -1;
  config->offsets.insert(config->offsets.end(), offsets, offsets + count);
  config->settings.insert(config->settings.end(), count, *settings);
  return 0;
}

struct gpiod_request_config* gpiod_request_config_new() {
  return new gpiod_request_config;
}
void gpiod_request_config_free(struct gpiod_request_config* config) { delete config; }
void gpiod_request_config_set_consumer(struct gpiod_request_config*, const char*) {}
void gpiod_request_config_set_event_buffer_size(struct gpiod_request_config*, size_t) {}

struct gpiod_line_request* gpiod_chip_request_lines(struct gpiod_chip*,
                                                    struct gpiod_request_config*,
                                                    struct gpiod_line_config* config) {
  if (fake_gpio_fails()) return nullptr;
  errno = EBUSY;
  if (chip.busy) return nullptr;
  const gpiod_line_settings& first = config->settings.front();
  const bool outputs = first.direction == GPIOD_LINE_DIRECTION_OUTPUT;
  errno = EINVAL;
  if (!outputs && first.edge != GPIOD_LINE_EDGE_BOTH) return nullptr;
  for (size_t i = 0; i < config->offsets.size(); i++) {
    chip.held.insert(names[config->offsets[i]]);
    if (outputs) drive(config->offsets[i], config->settings[i].value);
  }
  return new gpiod_line_request{config->offsets, outputs};
}

void gpiod_line_request_release(struct gpiod_line_request* request) {
  for (unsigned offset : request->offsets) chip.held.erase(names[offset]);
  delete request;
}

int gpiod_line_request_set_value(struct gpiod_line_request* request, unsigned offset,
                                 gpiod_line_value value) {
  if (fake_gpio_fails() || chip.broken || !request->outputs) return -1;
  return drive(offset, value);
}

int gpiod_line_request_get_values(struct gpiod_line_request* request, gpiod_line_value* values) {
  if (fake_gpio_fails() || chip.deaf) return -1;
  for (unsigned offset : request->offsets) {
    *values++ = chip.levels[names[offset]] ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
  }
  return 0;
}

int gpiod_line_request_wait_edge_events(struct gpiod_line_request* request, int64_t) {
  if (fake_gpio_fails() || chip.deaf) return -1;
  for (unsigned offset : request->offsets) {
    if (!chip.edges.empty() && names[offset] == chip.edges.front().line) return 1;
  }
  return 0;
}

struct gpiod_edge_event_buffer* gpiod_edge_event_buffer_new(size_t) {
  return new gpiod_edge_event_buffer;
}
void gpiod_edge_event_buffer_free(struct gpiod_edge_event_buffer* buffer) { delete buffer; }

int gpiod_line_request_read_edge_events(struct gpiod_line_request*,
                                        struct gpiod_edge_event_buffer* buffer, size_t) {
  if (fake_gpio_fails()) return -1;
  const FakeGpio::Edge edge = chip.edges.front();
  chip.edges.pop_front();
  chip.levels[edge.line] = edge.level;
  for (size_t i = 0; i < names.size(); i++) {
    if (names[i] == edge.line) buffer->event.offset = unsigned(i);
  }
  buffer->event.level = edge.level;
  buffer->event.at_ns = uint64_t(edge.at_us * 1e3);
  return 1;
}

struct gpiod_edge_event* gpiod_edge_event_buffer_get_event(struct gpiod_edge_event_buffer* buffer,
                                                           unsigned long) {
  return &buffer->event;
}
unsigned gpiod_edge_event_get_line_offset(struct gpiod_edge_event* event) { return event->offset; }
uint64_t gpiod_edge_event_get_timestamp_ns(struct gpiod_edge_event* event) { return event->at_ns; }
gpiod_edge_event_type gpiod_edge_event_get_event_type(struct gpiod_edge_event* event) {
  return event->level ? GPIOD_EDGE_EVENT_RISING_EDGE : GPIOD_EDGE_EVENT_FALLING_EDGE;
}
}
