// lamella twin: photographs of a subject with known layers.
#include <memory>

#include "apps/commands.h"
#include "base/error.h"
#include "base/progress.h"
#include "io/whole_file.h"
#include "twin/session_writer.h"
#include "twin/truth_writer.h"

namespace lamella::apps {

namespace {

struct TwinArguments {
  twin::Photographer::Options subject;
  std::string out;
  float noise = 1.f;
};

void run_twin(const TwinArguments& a) {
  const Stopwatch clock;
  const twin::Photographer photographer(a.subject);
  std::printf("subject in %.1f s\n", clock.seconds());
  twin::Studio studio(photographer, a.noise, a.subject.seed);
  WholeFolder session(a.out);
  twin::write_session(session.path(), photographer, &studio);
  twin::write_truth(session.path(), photographer);
  session.commit();
  std::printf("%s in %.1f s\n", a.out.c_str(), clock.seconds());
}

}  // namespace

void add_twin(CLI::App& app, int*) {
  const auto a = std::make_shared<TwinArguments>();
  CLI::App* command = app.add_subcommand("twin", "Photographs of a subject with known layers");
  command->add_option("--subject", a->subject.subject, "head or sphere");
  command->add_option("--seed", a->subject.seed, "another face, skin and noise");
  command->add_option("--scale", a->subject.scale, "times 600 x 750 pixels");
  command->add_option("--out", a->out, "session folder to write");
  command->add_option("--noise", a->noise, "times the sensor's noise");
  command->callback([a] { run_twin(*a); });
}

}  // namespace lamella::apps
