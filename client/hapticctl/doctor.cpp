#include <cstdio>

#include "commands.hpp"
#include "doctor/measure.hpp"

namespace haptic::ctl {

/// Examines the host that it runs on; needs no server.
int doctor(const Options& options) {
  StiffnessQuestion question;
  question.device_damping = options.device_damping;
  question.rendered_damping = options.damping;
  const double seconds = options.seconds > 0.0 ? options.seconds : kDoctorSeconds;
  if (!options.json) std::fprintf(stderr, "measuring %g s of a bare 1 kHz loop ...\n", seconds);
  const HostAnswers answers = ask_host(seconds, question.period_s);
  const Report report = examine(HostFiles(), answers, question);
  std::printf("%s\n",
              (options.json ? to_json(report, question) : to_text(report, question)).c_str());
  return report.grade == "unfit" ? 1 : 0;
}

}  // namespace haptic::ctl
