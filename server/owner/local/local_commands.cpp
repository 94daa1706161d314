#include "server/owner/local/local_commands.hpp"

#include <spdlog/spdlog.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "haptic/core/error.hpp"
#include "server/base/steady_now.hpp"
#include "server/base/thread_setup.hpp"
#include "server/crossing/link_messages.hpp"

namespace haptic::server {
namespace {

using Kind = ControlCommand::Kind;

/// Whatever local users ask, this thread leaves two thirds of a core to others.
constexpr core::Duration kWindow = std::chrono::milliseconds(3);
constexpr core::Duration kBudget = std::chrono::milliseconds(1);

}  // namespace

LocalCommands::LocalCommands(Owner& owner, RestartFront restart_front)
    : owner_(owner),
      restart_front_(std::move(restart_front)),
      wakes_(eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  if (!wakes_) throw core::TransportError("eventfd of the local control socket");
}

LocalCommands::~LocalCommands() {
  stop();
}

void LocalCommands::listen(Config config) {
  control_ = std::make_unique<ControlSocket>(
      config.places, [this](const ControlCommand& it) { command(it); },
      [launcher = config.launcher](pid_t process) {
        return launcher > 0 && process > 0 && getsid(process) == launcher;
      });
  health_ = std::make_unique<LocalHealth>(owner_, std::move(config.addresses));
  thread_ = std::thread([this, realtime = config.realtime] { run(realtime); });
}

void LocalCommands::stop() {
  if (!thread_.joinable()) return;
  stopping_.store(true);
  wake();
  thread_.join();
  control_.reset();
}

void LocalCommands::run(bool realtime) noexcept {
  set_thread_up("local control", realtime);
  core::TimePoint window{};
  core::Duration busy{0};
  while (!stopping_.load()) {
    wait_.assign(1, {wakes_.get(), POLLIN, 0});
    const core::Duration patience = control_->add_to(wait_, steady_now());
    poll(wait_.data(), wait_.size(), static_cast<int>(patience / std::chrono::milliseconds(1)) + 1);
    now_ = steady_now();
    turn();
    const core::TimePoint ended = steady_now();
    if (ended - window >= kWindow) {
      window = now_;
      busy = {};
    }
    busy += ended - now_;
    if (busy >= kBudget) std::this_thread::sleep_for(window + kWindow - ended);
  }
}

void LocalCommands::turn() {
  std::uint64_t rings = 0;
  static_cast<void>(read(wakes_.get(), &rings, sizeof rings) == sizeof rings);
  control_->turn(now_);
  give_answers();
  health_->look(now_);
}

void LocalCommands::give_answers() {
  std::vector<Answer> answers;
  std::vector<std::pair<std::uint64_t, std::string>> texts;
  {
    const std::lock_guard lock(mutex_);
    answers.swap(answers_);
    texts.swap(texts_);
  }
  for (const auto& [reply_to, text] : texts) control_->answer(reply_to, text);
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
    if (--open.open == 0) control_->answer(open.reply_to, open.text);
  }
}

void LocalCommands::wake() {
  static_cast<void>(eventfd_write(wakes_.get(), 1));
}

void LocalCommands::answer(std::uint64_t reply_to, const std::string& text) {
  if (reply_to == 0) return;
  const std::lock_guard lock(mutex_);
  texts_.emplace_back(reply_to, text);
  wake();
}

void LocalCommands::on_answer(const Answer& answer) {
  const std::lock_guard lock(mutex_);
  answers_.push_back(answer);
  wake();
}

void LocalCommands::front(const FrontView& view) {
  const std::lock_guard lock(mutex_);
  front_ = view;
}

void LocalCommands::command(const ControlCommand& command) {
  if (command.kind == Kind::kRestartFront) return restart_front_(command.reply_to);
  if (command.kind == Kind::kHealth) {
    std::unique_lock lock(mutex_);
    const FrontView front = front_;
    lock.unlock();
    return control_->answer(command.reply_to, health_->text(front, now_));
  }
  std::vector<std::size_t> devices;
  for (std::size_t i = 0; i < owner_.devices().size(); ++i) {
    if (command.device.empty() || command.device == owner_.devices()[i].name) devices.push_back(i);
  }
  if (devices.empty()) {
    return control_->answer(command.reply_to, "refused: there is no such device");
  }
  if (command.kind == Kind::kClear && devices.size() > 1) {
    return control_->answer(command.reply_to, "refused: which device? A clear is of one");
  }
  ask(command, devices);
}

void LocalCommands::ask(const ControlCommand& command, const std::vector<std::size_t>& devices) {
  const bool clear = command.kind == Kind::kClear;
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
  if (!clear) tell_stop(command, who);
}

void LocalCommands::tell_stop(const ControlCommand& command, const std::string& who) {
  const auto left_out = lines_[command.trusted ? 1 : 0].next(now_);
  if (!left_out) return;
  spdlog::warn("local emergency stop of {} by {}{}",
               command.device.empty() ? "all" : command.device, who,
               *left_out == 0 ? "" : fmt::format(" ({} more are not in this log)", *left_out));
}

}  // namespace haptic::server
