#include "server/owner/local/local_commands.hpp"

#include <spdlog/spdlog.h>

#include "server/crossing/link_messages.hpp"

namespace haptic::server {

using Command = ControlSocket::Command;

void LocalCommands::listen(const std::string& address) {
  control_ = std::make_unique<ControlSocket>(control_name(address),
                                             [this](const auto& it) { command(it); });
}

void LocalCommands::add_to(std::vector<pollfd>& wait) const {
  if (control_) control_->add_to(wait);
}

void LocalCommands::turn(core::TimePoint now) {
  now_ = now;
  if (control_) control_->turn();
  std::vector<Answer> answers;
  {
    const std::lock_guard lock(mutex_);
    answers.swap(answers_);
  }
  for (const Answer& one : answers) {
    const auto entry = asked_.extract(one.id);
    if (!entry) continue;
    Open& open = *entry.mapped().open;
    if (one.refusal) {
      open.refused = true;
      open.text = "refused: " + one.refusal->message.str();
    } else if (!open.refused) {
      open.text += "\n" + (open.clear ? std::to_string(one.faults.bits())
                                      : owner_.devices()[entry.mapped().device].name);
    }
    if (--open.open == 0) answer(open.reply_to, open.text);
  }
}

void LocalCommands::answer(std::uint64_t reply_to, const std::string& text) {
  if (control_) control_->answer(reply_to, text);
}

void LocalCommands::on_answer(const Answer& answer) {
  const std::lock_guard lock(mutex_);
  answers_.push_back(answer);
}

void LocalCommands::command(const Command& command) {
  if (command.kind != Command::Kind::kStop && command.kind != Command::Kind::kClear) {
    return of_front_(command.kind, command.reply_to);
  }
  std::vector<std::size_t> devices;
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    if (command.device.empty() || command.device == owner_.devices()[i].name) devices.push_back(i);
  }
  if (devices.empty()) return answer(command.reply_to, "refused: there is no such device");
  if (command.kind == Command::Kind::kClear && devices.size() > 1) {
    return answer(command.reply_to, "refused: which device? A clear is of one");
  }
  ask(command, devices);
}

void LocalCommands::ask(const Command& command, const std::vector<std::size_t>& devices) {
  const bool clear = command.kind == Command::Kind::kClear;
  const std::string who = "user " + std::to_string(command.user) + " of this host";
  const auto open = std::make_shared<Open>(Open{command.reply_to, devices.size()});
  open->clear = clear;
  for (const std::size_t device : devices) {
    Request request;
    request.id = kLocalIds | ++last_id_;
    request.kind = clear ? Request::Kind::kClear : Request::Kind::kStop;
    request.device = static_cast<std::uint32_t>(device);
    request.local = true;
    request.faults = core::FaultSet(command.faults);
    request.text = command.reason.empty() ? who : command.reason + " (" + who + ")";
    request.time = now_;
    asked_[request.id] = {open, device};
    owner_.post(request);
  }
  if (!clear) {
    spdlog::warn("local emergency stop of {} by {}",
                 devices.size() == 1 ? owner_.devices()[devices[0]].name : "all", who);
  }
}

}  // namespace haptic::server
