#include "verdict.h"

#include <stdio.h>

// The first edge that made the shot bad, in words; a shot without one was dropped.
static void tell_shot(const struct roll* roll, size_t number, char* text, size_t size) {
  const struct shot* shot = &roll->shots[number];
  const struct take* take = &roll->takes[shot->take];
  for (size_t i = 0; i < take->timeline.count; i++) {
    const struct edge* edge = &take->timeline.edges[i];
    if (!take->player.played[i].late || edge->step != shot->step) continue;
    snprintf(text, size, "%s of step %u by %.0f us", timeline_line_name(edge->line), shot->place,
             take->player.played[i].actual_us - edge->t_us);
    return;
  }
  snprintf(text, size, "step %u %s", shot->place,
           shot->dropped ? "dropped by a camera" : "while the analyser moved");
}

void verdict_write(const struct roll* roll, unsigned frames, const char* why_not,
                   lamella_v1_BurstDone* done) {
  char first[64] = "";
  size_t bad = 0;
  *done =
      (lamella_v1_BurstDone){.frame_count = frames, .late_edges = (uint32_t)roll_late_count(roll)};
  for (size_t i = 0; i < roll->shot_count; i++) {
    const bool replaced = roll->shots[i].replaced_by >= 0;
    done->retaken += replaced;
    if (!roll->shots[i].bad) continue;
    if (first[0] == '\0') tell_shot(roll, i, first, sizeof first);
    bad++;
    done->marked = done->marked || !replaced;
  }
  const size_t edges = roll_edge_count(roll);
  if (bad == 0) {
    snprintf(done->verdict, sizeof done->verdict, "%zu steps, %zu edges, none late",
             roll->takes[0].plan.count, edges);
  } else if (!done->marked) {
    snprintf(done->verdict, sizeof done->verdict,
             "%zu steps, %zu edges, %u late; retaken: %u, the first for %s",
             roll->takes[0].plan.count, edges, (unsigned)done->late_edges, (unsigned)done->retaken,
             first);
  } else {
    char late[48] = "";
    if (done->late_edges > 0) {
      snprintf(late, sizeof late, "%u of %zu edges late, the first ", (unsigned)done->late_edges,
               edges);
    }
    snprintf(done->verdict, sizeof done->verdict, "MARKED: %s%s%s%s", late, first,
             why_not[0] == '\0' ? "" : "; not retaken: ", why_not);
  }
}
