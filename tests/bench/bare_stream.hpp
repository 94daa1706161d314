#pragma once
/// The peer of the session's stream: the same messages over the plainest stream that gRPC offers.

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <condition_variable>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "haptic/v1/haptic_service.grpc.pb.h"
#include "tests/bench/product.hpp"

namespace haptic::bench {

class BareServer final : public v1::HapticService::CallbackService {
 public:
  grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse>* Session(
      grpc::CallbackServerContext*) override {
    return new Reactor(*this);
  }
  std::mutex mutex;
  std::vector<double> up_us{};

 private:
  class Reactor final : public grpc::ServerBidiReactor<v1::SessionRequest, v1::SessionResponse> {
   public:
    explicit Reactor(BareServer& server) : server_(server) {
      StartRead(&in_);
      writer_ = std::thread([this] {
        auto next = std::chrono::steady_clock::now();
        while (!over_) {
          next += std::chrono::milliseconds(1);
          std::this_thread::sleep_until(next);
          if (writing_.exchange(true)) continue;
          v1::DeviceState& state = *out_.mutable_state();
          fill(state);
          state.set_server_time_ns(now_ns());
          StartWrite(&out_);
        }
        while (writing_) std::this_thread::sleep_for(std::chrono::milliseconds(1));
        Finish(grpc::Status::OK);
      });
    }
    void OnReadDone(bool ok) override {
      if (!ok) {
        over_ = true;
        return;
      }
      {
        const std::lock_guard lock(server_.mutex);
        server_.up_us.push_back(static_cast<double>(now_ns() - in_.proxy().source_time_ns()) *
                                1e-3);
      }
      StartRead(&in_);
    }
    void OnWriteDone(bool) override { writing_ = false; }
    void OnDone() override {
      writer_.join();
      delete this;
    }
    static void fill(v1::DeviceState& state) {  // as large as the finger's
      state.Clear();
      state.set_seq(1'000'000);
      for (int i = 0; i < 2; ++i) {
        state.add_q(0.01 + i);
        state.add_x_probe(0.5);
        state.add_x(0.4);
        state.add_q_star(0.02);
      }
      state.add_q_dot(0.1);
      state.add_tau_a(1.5);
      state.add_tau_elastic(1.4);
      state.add_stiffness_in_effect(1500.0);
      state.set_proxy_seq_used(1000);
      state.set_proxy_age_us(3000);
      state.set_gain(1.0);
    }

   private:
    BareServer& server_;
    v1::SessionRequest in_;
    v1::SessionResponse out_;
    std::atomic<bool> writing_{false}, over_{false};
    std::thread writer_;
  };
};

class BareClient final : public grpc::ClientBidiReactor<v1::SessionRequest, v1::SessionResponse> {
 public:
  explicit BareClient(const std::string& address)
      : stub_(v1::HapticService::NewStub(
            grpc::CreateChannel(address, grpc::InsecureChannelCredentials()))) {
    stub_->async()->Session(&context_, this);
    AddHold();
    StartRead(&in_);
    StartCall();
  }
  ~BareClient() override {
    context_.TryCancel();
    RemoveHold();
    std::unique_lock lock(mutex);
    done_cv_.wait(lock, [this] { return done_; });
  }
  void send(std::uint64_t seq) {
    if (writing_.exchange(true)) return;
    v1::ProxySample& sample = *out_.mutable_proxy();
    sample.set_seq(seq);
    sample.set_mode(v1::PROXY_MODE_HELD);
    sample.clear_position();
    sample.add_position(0.4);
    sample.add_position(0.5);
    sample.set_source_time_ns(now_ns());
    StartWrite(&out_);
  }
  std::mutex mutex;
  std::vector<double> down_us{};

 private:
  void OnReadDone(bool ok) override {
    if (!ok) return;
    {
      const std::lock_guard lock(mutex);
      down_us.push_back(static_cast<double>(now_ns() - in_.state().server_time_ns()) * 1e-3);
    }
    StartRead(&in_);
  }
  void OnWriteDone(bool) override { writing_ = false; }
  void OnDone(const grpc::Status&) override {
    const std::lock_guard lock(mutex);
    done_ = true;
    done_cv_.notify_all();
  }
  std::unique_ptr<v1::HapticService::Stub> stub_;
  grpc::ClientContext context_;
  v1::SessionRequest out_;
  v1::SessionResponse in_;
  std::atomic<bool> writing_{false};
  bool done_{false};
  std::condition_variable done_cv_;
};

}  // namespace haptic::bench
