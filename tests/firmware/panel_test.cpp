#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <random>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

extern "C" {
#include "panel.h"
}

namespace {

constexpr double kTickUs = 10e3;

std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream stream(line);
  std::string cell;
  std::getline(stream, cell, '|');  // before the first bar
  while (std::getline(stream, cell, '|')) {
    const size_t from = cell.find_first_not_of(' '), to = cell.find_last_not_of(' ');
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
  }
  return cells;
}

// The rows of README.md's table of codes.
std::vector<std::vector<std::string>> readme_table() {
  std::ifstream file(LAMELLA_README);
  std::vector<std::vector<std::string>> rows;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line.rfind("| code | light | buzzer |", 0) == 0) {
      inside = true;
      std::getline(file, line);  // the rule below the heading
    } else if (inside && line.rfind("|", 0) == 0) {
      rows.push_back(cells_of(line));
    } else {
      inside = false;
    }
  }
  return rows;
}

std::string text_of(const panel_pattern& pattern) {
  char text[64];
  panel_pattern_text(&pattern, text);
  return text;
}

// Feeds a button and returns what it came to.
std::vector<panel_event> feel(struct panel* panel, double from_us, double to_us, bool pressed) {
  std::vector<panel_event> events;
  for (double t_us = from_us; t_us < to_us; t_us += 1e3) {
    const panel_event event = panel_feel(panel, pressed, t_us);
    if (event != PANEL_NOTHING) events.push_back(event);
  }
  return events;
}

}  // namespace

TEST(Panel, ReadmeHasTheTableOfCodesThatTheFirmwarePlays) {
  const auto rows = readme_table();
  ASSERT_EQ(rows.size(), size_t{PANEL_CODES});
  for (size_t i = 0; i < rows.size(); i++) {
    const panel_entry& entry = kPanelTable[i];
    ASSERT_EQ(rows[i].size(), 4u) << i;
    EXPECT_EQ(rows[i][0], entry.name);
    EXPECT_EQ(rows[i][1], text_of(entry.light)) << entry.name;
    EXPECT_EQ(rows[i][2], text_of(entry.buzzer)) << entry.name;
    EXPECT_EQ(rows[i][3], entry.meaning) << entry.name;
  }
}

TEST(Panel, NoTwoCodesLookAndSoundTheSame) {
  for (int a = 0; a < PANEL_CODES; a++) {
    for (int b = 0; b < a; b++) {
      const auto both = [](int i) {
        return text_of(kPanelTable[i].light) + "/" + text_of(kPanelTable[i].buzzer);
      };
      EXPECT_NE(both(a), both(b)) << kPanelTable[a].name << ", " << kPanelTable[b].name;
    }
  }
}

// What stays until somebody acts must be told by the light alone: the buzzer has fallen silent.
TEST(Panel, LastingCodesAreToldApartByTheLightAlone) {
  for (int a = PANEL_MARKED; a < PANEL_CODES; a++) {
    for (int b = 0; b < a; b++) {
      EXPECT_NE(text_of(kPanelTable[a].light), text_of(kPanelTable[b].light))
          << kPanelTable[a].name << ", " << kPanelTable[b].name;
    }
  }
}

TEST(Panel, PatternPlaysItsPulsesPauseAndRounds) {
  const panel_pattern pattern = {250, 250, 2, 2000, 3};
  EXPECT_EQ(text_of(pattern), "2 x 250/250 ms, pause 2000 ms, 3 rounds");
  for (int round = 0; round < 3; round++) {
    const double start_us = round * 3e6;
    EXPECT_TRUE(panel_pattern_level(&pattern, start_us + 1));
    EXPECT_FALSE(panel_pattern_level(&pattern, start_us + 251e3));
    EXPECT_TRUE(panel_pattern_level(&pattern, start_us + 501e3));
    EXPECT_FALSE(panel_pattern_level(&pattern, start_us + 751e3));
    EXPECT_FALSE(panel_pattern_level(&pattern, start_us + 2.99e6));
  }
  EXPECT_FALSE(panel_pattern_level(&pattern, 9.001e6));
  EXPECT_DOUBLE_EQ(panel_pattern_length_us(&pattern), 9e6);
}

TEST(Panel, TheLightNeverFlashesMoreThanThreeTimesASecondWhateverIsShown) {
  std::mt19937 random(3);
  struct panel panel;
  panel_init(&panel, 0);
  double last_rise_us = -INFINITY;
  bool was_on = false;
  for (double t_us = 0; t_us < 600e6; t_us += kTickUs) {
    if (random() % 17 == 0) panel_show(&panel, panel_code(random() % PANEL_CODES), t_us);
    panel_tick(&panel, t_us);
    if (panel.light && !was_on) {
      ASSERT_GE(t_us - last_rise_us, 1e6 / 3) << kPanelTable[panel.code].name;
      last_rise_us = t_us;
    }
    was_on = panel.light;
  }
}

TEST(Panel, EveryCodesOwnPatternKeepsToThreeFlashesASecond) {
  for (const panel_entry& entry : kPanelTable) {
    if (entry.light.count == 0 || entry.light.off_ms == 0) continue;
    EXPECT_GE(entry.light.on_ms + entry.light.off_ms, 334) << entry.name;
  }
}

TEST(Panel, ShowingTheSameCodeAgainDoesNotRestartIt) {
  struct panel panel;
  panel_init(&panel, 0);
  panel_show(&panel, PANEL_FAULT_HOT, 0);
  panel_show(&panel, PANEL_FAULT_HOT, 300e3);
  panel_tick(&panel, 300e3);
  EXPECT_FALSE(panel.light);
}

TEST(Panel, ABouncingButtonIsOneClick) {
  struct panel panel;
  panel_init(&panel, 0);
  for (double t_us = 0; t_us < 10e3; t_us += 2e3) {
    EXPECT_EQ(panel_feel(&panel, std::fmod(t_us, 4e3) < 2e3, t_us), PANEL_NOTHING);
  }
  EXPECT_TRUE(feel(&panel, 10e3, 200e3, true).empty());
  EXPECT_EQ(feel(&panel, 200e3, 400e3, false), std::vector<panel_event>{PANEL_CLICKED});
}

TEST(Panel, ASpikeIsNoClick) {
  struct panel panel;
  panel_init(&panel, 0);
  EXPECT_TRUE(feel(&panel, 100e3, 120e3, true).empty());
  EXPECT_TRUE(feel(&panel, 120e3, 500e3, false).empty());
}

TEST(Panel, AHeldButtonIsHeldOnceAndNoClick) {
  struct panel panel;
  panel_init(&panel, 0);
  EXPECT_TRUE(feel(&panel, 0, 2.9e6, true).empty());
  EXPECT_EQ(feel(&panel, 2.9e6, 8e6, true), std::vector<panel_event>{PANEL_HELD});
  EXPECT_EQ(feel(&panel, 8e6, 9e6, false), std::vector<panel_event>{PANEL_RELEASED});
}
