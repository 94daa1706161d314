#pragma once
/// A board in virtual time. The code of hw/firmware runs every millisecond between the sensors and
/// the drive of a Rig, at the end of a serial link that may lose and damage bytes. By default the
/// board closes the force loop on its load cell itself (core::ForceLoop).

#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <vector>

#include "haptic/core/control/force_loop.hpp"
#include "haptic/core/model/kinematics.hpp"
#include "hw/emulator/faults.hpp"
#include "hw/emulator/rig.hpp"
#include "hw/firmware/haptic_board.h"

namespace haptic::hw::emulator {

/// How the board follows a command.
enum class BoardControl : std::uint8_t {
  kForceLoop,  ///< as the reference of its own loop on the load cell, like the paper's device
  kDrive,      ///< as the force of the drive; the host closes the loop
  kPosition,   ///< as a position of the rod: a servo on the potentiometer
};

struct EmulatorConfig {
  std::uint64_t seed{1};
  std::string serial{"EMULATOR-1"};
  std::string model{"finger_same_sign"};  ///< the linkage of the default FingerDimensions
  std::uint32_t watchdog_us{25000};
  /// 0: bytes pass at once. 2000: only every 2 ms, both ways, as over the paper's USB link.
  std::uint32_t link_period_us{0};
  double clock_ppm{40.0};  ///< the board's crystal against the host's
  double drop{0.0};        ///< share of bytes lost, each way
  double corrupt{0.0};     ///< share of bytes with one bit flipped, each way
  std::vector<FaultSpec> faults{};
  ActuatorParameters actuator{};
  SensorParameters sensors{};
  core::ForceLoopGains force_loop{20.0, 200.0, 15.0, 2.0, 131.0};
  BoardControl control{BoardControl::kForceLoop};
  /// Errors of the potentiometer of l_x: reading = scale (l_x + offset).
  double l_x_scale{1.0}, l_x_offset{0.0};  ///< 1, m
  double force_offset{0.0};                ///< N that the load cell reads without load
  double force_over_limit{60.0};           ///< N: more in the cell than this is a fault
};

class EmulatedBoard {
 public:
  static constexpr std::uint64_t kSampleUs = 1000;

  EmulatedBoard(const EmulatorConfig& config, HandIntent intent,
                const std::shared_ptr<const core::Kinematics>& kinematics);
  EmulatedBoard(const EmulatedBoard&) = delete;
  EmulatedBoard& operator=(const EmulatedBoard&) = delete;

  /// Lets time pass until `now_us` since the start.
  void advance(std::uint64_t now_us);
  /// Bytes from the host, arriving now.
  void receive(std::span<const std::uint8_t> bytes);
  /// Bytes for the host since the last call. Bytes not taken in time are lost: the board
  /// has room for 1 KiB.
  [[nodiscard]] std::vector<std::uint8_t> take_output();
  /// False: the port is gone.
  [[nodiscard]] bool plugged() const noexcept { return !is_active(FaultKind::kUnplug); }
  /// How many more bytes the port takes now. Frames beyond that are counted as without room.
  void set_room(std::size_t bytes) noexcept { room_ = bytes; }

  /// From now on these shares of the bytes are lost and damaged.
  void set_noise(double drop, double corrupt) noexcept {
    config_.drop = drop;
    config_.corrupt = corrupt;
  }
  void add_fault(const FaultSpec& fault) { config_.faults.push_back(fault); }

  [[nodiscard]] const hb_board& firmware() const noexcept { return board_; }
  [[nodiscard]] const Rig& rig() const noexcept { return rig_; }
  [[nodiscard]] Rig& rig() noexcept { return rig_; }
  [[nodiscard]] bool drives() const noexcept { return drives_; }          ///< the bridge is on
  [[nodiscard]] double reference() const noexcept { return reference_; }  ///< N
  [[nodiscard]] std::uint64_t now_us() const noexcept { return now_us_; }

 private:
  static bool send(void* context, const std::uint8_t* bytes, std::size_t length);
  [[nodiscard]] bool is_active(FaultKind kind) const noexcept;
  [[nodiscard]] std::uint64_t board_us() const noexcept;
  [[nodiscard]] bool has_supply();
  [[nodiscard]] bool stalled(const Readings& readings) noexcept;
  [[nodiscard]] double drive_force(const Readings& readings) noexcept;
  void control();
  void deliver();
  void disturb(Readings& readings);
  void pass(std::span<const std::uint8_t> bytes, std::vector<std::uint8_t>& out);

  EmulatorConfig config_;
  hb_dof dofs_[2]{};
  hb_config board_config_{};
  hb_board board_{};
  Rig rig_;
  core::ForceLoop force_loop_;
  std::mt19937_64 random_;
  std::uint64_t now_us_{0}, booted_us_{0};
  bool powered_{true};
  bool drives_{false};
  double reference_{0.0};
  double drift_{0.0};  ///< m, of the potentiometer
  float stuck_at_{0.0F};
  bool was_stuck_{false};
  int pushing_in_vain_{0};  ///< ms with the loop at its limit and the rod standing
  float stood_at_{0.0F};    ///< m
  std::size_t room_{1024};
  std::vector<std::uint8_t> incoming_{}, outgoing_{}, released_{};
};

}  // namespace haptic::hw::emulator
