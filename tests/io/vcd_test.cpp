#include "io/vcd.h"

#include <gtest/gtest.h>

namespace lamella {
namespace {

v1::TimedEdge edge(const std::string& line, double planned_us, unsigned value) {
  v1::TimedEdge e;
  e.set_line(line);
  e.set_planned_us(planned_us);
  e.set_actual_us(planned_us + 0.25);
  e.set_value(value);
  return e;
}

google::protobuf::RepeatedPtrField<v1::TimedEdge> burst() {
  google::protobuf::RepeatedPtrField<v1::TimedEdge> edges;
  *edges.Add() = edge("BLANK", 20.5, 1);
  *edges.Add() = edge("BLANK", 10.001, 0);
  *edges.Add() = edge("SHIFT", 3, 0);
  return edges;
}

TEST(Vcd, StampsEdgesInNanosecondsInOrderOfTime) {
  const std::string text = vcd_text(burst(), EdgeTime::kPlanned);
  EXPECT_NE(text.find("$timescale 1 ns $end"), std::string::npos);
  EXPECT_NE(text.find("#10001\n0!\n"), std::string::npos) << text;
  EXPECT_LT(text.find("#10001\n"), text.find("#20500\n"));
}

TEST(Vcd, TellsWhatReallyHappenedWhereAsked) {
  EXPECT_NE(vcd_text(burst(), EdgeTime::kActual).find("#10251\n"), std::string::npos);
}

TEST(Vcd, ShowsAMomentAsAPulse) {
  const std::string text = vcd_text(burst(), EdgeTime::kPlanned);
  EXPECT_NE(text.find("#3000\n1\"\n"), std::string::npos) << text;
  EXPECT_NE(text.find("#13000\n0\"\n"), std::string::npos) << text;
}

TEST(Vcd, StartsWithTheLightsOff) {
  EXPECT_NE(vcd_text(burst(), EdgeTime::kPlanned).find("$dumpvars\n1!\n0\"\n$end"),
            std::string::npos);
}

TEST(Vcd, ShowsALineThatIsActiveLowAsAProbeSeesIt) {
  google::protobuf::RepeatedPtrField<v1::TimedEdge> edges;
  *edges.Add() = edge("TRIGGER", 1, 1);
  *edges.Add() = edge("TRIGGER", 2, 0);
  const std::string high = vcd_text(edges, EdgeTime::kPlanned);
  EXPECT_NE(high.find("$dumpvars\n0!\n$end\n#1000\n1!\n#2000\n0!\n"), std::string::npos) << high;
  const std::string low = vcd_text(edges, EdgeTime::kPlanned, {"TRIGGER"});
  EXPECT_NE(low.find("$dumpvars\n1!\n$end\n#1000\n0!\n#2000\n1!\n"), std::string::npos) << low;
}

}  // namespace
}  // namespace lamella
