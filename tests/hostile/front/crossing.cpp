// Messages to the owner that no honest front sends: forged, replayed, out of turn, of random bits.

#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>
#include <thread>

#include "server/base/steady_now.hpp"
#include "server/crossing/packet_socket.hpp"
#include "tests/hostile/front/inside.hpp"

namespace haptic::hostile {
namespace {

using namespace std::chrono_literals;
using server::FrontMessage;
using server::ProxySample;
using server::Request;
using server::SessionId;
using Kind = Request::Kind;

const std::string kNoText = "\xff\x80\x1b[31m\xc3(\x9b\r\n2026 forged line\xed\xa0\x80";

ProxySample forged(std::uint32_t epoch, std::uint64_t seq) {
  ProxySample sample = held(epoch, seq);
  sample.ticket = Spy::kForged;
  return sample;
}

/// Posts a request of the attacker's own, and waits a little for its answer.
void ask(Inside& in, Request request) {
  request.id = Spy::kSession;
  in.spy.answered = 0;
  in.owner.post(request);
  for (const auto end = Clock::now() + 50ms; in.spy.answered == 0 && Clock::now() < end;) {
    std::this_thread::sleep_for(100us);
  }
}

Request of_session(Kind kind, const SessionId& session) {
  Request request;
  request.kind = kind;
  request.session_id = session;
  request.lease.client_name = "inside";
  request.lease.nominal_rate_hz = 100.0;
  request.lease.priority = server::Priority::kOperator;
  request.lease.resumable = true;
  return request;
}

/// Samples of wrong leases, numbers and devices. The owner must refuse them all.
void samples_of_others(Inside& in) {
  const std::uint32_t epoch = in.spy.epoch;
  constexpr std::uint64_t kHigh = std::uint64_t{1} << 50U;
  for (const std::uint32_t other : {0U, 1U, epoch - 1, epoch + 1, 1U << 31U, ~0U}) {
    if (other != epoch) in.owner.post(forged(other, kHigh));
  }
  for (const std::uint64_t seq : {0, 1}) in.owner.post(forged(epoch, seq));
  for (const std::uint32_t device : {1U, 2U, 64U, ~0U}) {
    ProxySample sample = forged(epoch, kHigh);
    sample.device = device;
    in.owner.post(sample);
  }
}

/// Requests for sessions that are over, or never were. Every answer must be a refusal.
void requests_of_others(Inside& in, const SessionId& former) {
  std::string near = in.owner.status(0).holder.str();
  if (!near.empty()) near.back() = near.back() == '0' ? '1' : '0';
  SessionId odd;
  std::memset(static_cast<void*>(&odd), 0xFF, sizeof odd);  // its size too
  std::uint64_t id = Spy::kForged;
  for (const SessionId& session :
       {former, SessionId(near), SessionId(std::string(32, '\0')), SessionId(), odd}) {
    for (const Kind kind :
         {Kind::kOpen, Kind::kTrack, Kind::kEngage, Kind::kRelease, Kind::kSettings}) {
      Request request = of_session(kind, session);
      request.id = ++id;
      request.lease.resume = session;
      in.owner.post(request);
    }
    for (const Kind kind : {Kind::kClose, Kind::kLose, Kind::kCancel}) {
      Request request = of_session(kind, session);
      request.id = 1;  // the front's own may have it
      in.owner.post(request);
    }
    std::this_thread::sleep_for(2ms);
  }
}

/// The same beat, with what a message can bring or how it can be sent.
void oddly_sent(Inside&) {
  FrontMessage beat;
  beat.kind = FrontMessage::Kind::kBeat;
  std::vector<iovec> pieces;
  auto* const bytes = reinterpret_cast<char*>(&beat);
  constexpr std::size_t kPieces = 1000;
  for (std::size_t i = 0; i < kPieces; ++i) {
    pieces.push_back({bytes + i, i + 1 < kPieces ? 1 : sizeof beat - i});
  }
  msghdr message{};
  message.msg_iov = pieces.data();
  message.msg_iovlen = pieces.size();
  for (const int flags : std::array<int, 5>{0, MSG_EOR, MSG_MORE, MSG_CONFIRM, MSG_DONTROUTE}) {
    sendmsg(kLink, &message, MSG_DONTWAIT | MSG_NOSIGNAL | flags);
  }
  sendmsg(kLink, &message, MSG_DONTWAIT | MSG_OOB);
  struct {
    alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(ucred))> room;
  } control{};
  message.msg_control = control.room.data();
  message.msg_controllen = sizeof control.room;
  cmsghdr* const header = CMSG_FIRSTHDR(&message);
  for (const ucred who : {ucred{getpid(), getuid(), getgid()}, ucred{1, 0, 0}}) {
    *header = {CMSG_LEN(sizeof who), SOL_SOCKET, SCM_CREDENTIALS};
    std::memcpy(CMSG_DATA(header), &who, sizeof who);
    const bool sent = sendmsg(kLink, &message, MSG_DONTWAIT) >= 0;
    if (sent && who.pid == 1) answer("GOT IN credentials of another process");
  }
  for (const int type : {3, 4, 99}) {
    *header = {CMSG_LEN(sizeof(ucred)), type == 99 ? 99 : SOL_SOCKET, type};
    sendmsg(kLink, &message, MSG_DONTWAIT);
  }
}

void replays(Inside& in) {
  ask(in, of_session(Kind::kAdmitSession, {}));
  const SessionId former = in.spy.session;
  in.owner.post(of_session(Kind::kClose, former));
  while (in.goes_on()) {
    samples_of_others(in);
    requests_of_others(in, former);
    oddly_sent(in);
    std::this_thread::sleep_for(5ms);
  }
  if (in.spy.used != 0) answer("GOT IN a sample of another lease, number or device");
  if (in.spy.granted != 0) answer("GOT IN a request of a session that is none");
  answer("refused " + std::to_string(in.spy.refused));
}

template <typename T>
void fill_with_bits(T& value, std::mt19937_64& random) {
  constexpr std::array<double, 16> kOdd{0.0,      -0.0,      5e-324, 1e-310, -1e-300, 1e308,
                                        -1e308,   1e-12,     1000.0, 0.25,   0.5236,  1.0,
                                        HUGE_VAL, -HUGE_VAL, NAN,    -NAN};
  auto* const words = reinterpret_cast<unsigned char*>(static_cast<void*>(&value));
  for (std::size_t i = 0; i + 8 <= sizeof value; i += 8) {
    const double odd = kOdd[random() % kOdd.size()];
    const std::uint64_t bits = random() >> (random() % 64U);
    std::memcpy(words + i, random() % 2 == 0 ? static_cast<const void*>(&odd) : &bits, 8);
  }
}

/// Random bits in every field of samples that count and of requests of the session that holds.
void bits(Inside& in) {
  std::mt19937_64 random(static_cast<std::uint64_t>(getpid()));
  ProxySample sample;
  server::PoseSample pose;
  Request request;
  for (std::uint64_t seq = std::uint64_t{1} << 40U; in.goes_on(); ++seq) {
    fill_with_bits(sample, random);
    sample.device = random() % 16 == 0 ? static_cast<std::uint32_t>(random()) : 0;
    sample.ticket = Spy::kForged;
    sample.epoch = in.spy.epoch;
    sample.seq = seq;
    sample.mode = static_cast<core::ProxyMode>(random() % 5);
    sample.plane_count = random() % 3 == 0 ? 0 : static_cast<std::uint32_t>(random() % 70);
    for (auto& plane : sample.planes) {
      if (random() % 4 != 0) plane.normal.count = 2;
      if (random() % 2 == 0) plane.curvature_count = 0;
    }
    if (random() % 4 != 0) sample.position.count = 2;
    in.owner.post(sample);
    fill_with_bits(pose, random);
    pose.device = 0;
    in.owner.post(pose);
    fill_with_bits(request, random);
    request.kind = static_cast<Kind>(random() % 13);
    if (request.kind == Kind::kStop) request.device = 1;  // else no force comes back
    request.id = Spy::kForged + random() % 1000;
    if (random() % 2 == 0) request.session_id = in.owner.status(0).holder;
    in.owner.post(request);
    std::this_thread::sleep_for(500us);
  }
  answer("used " + std::to_string(in.spy.used) + ", refused " + std::to_string(in.spy.refused));
}

/// Times at the ends of what a number can say, and in the end the last number of a sample.
void times(Inside& in) {
  constexpr auto kLeast = std::numeric_limits<std::int64_t>::min();
  constexpr auto kMost = std::numeric_limits<std::int64_t>::max();
  std::uint64_t seq = std::uint64_t{1} << 40U;
  const auto now = [] { return server::steady_now().time_since_epoch().count(); };
  while (in.goes_on()) {
    for (const std::int64_t at : {kLeast, kLeast + 1, std::int64_t{-1}, std::int64_t{0},
                                  now() - 1'000'000'000, now() + 1'000'000'000, kMost}) {
      ProxySample sample = forged(in.spy.epoch, ++seq);
      const core::TimePoint odd{core::Duration(at)};
      if (seq % 3 == 0) sample.arrival = odd;
      if (seq % 2 == 0) sample.left = server::Departure{odd, seq % 4 == 0 ? sample.arrival : odd};
      if (seq % 5 == 0) sample.valid_for = core::Duration(at);
      sample.tick_used = static_cast<std::uint64_t>(at);
      in.owner.post(sample);
      std::this_thread::sleep_for(3ms);
    }
  }
  in.owner.post(forged(in.spy.epoch, std::numeric_limits<std::uint64_t>::max()));
  std::this_thread::sleep_for(20ms);
}

/// Plays the session that holds: settings at their ends, engages, releases and cancels.
void moods(Inside& in) {
  const std::array<double, 6> ends{0.0, 1e9, 1e-300, -1.0, NAN, 25.0};
  for (std::uint64_t i = 0; in.goes_on(); ++i) {
    const SessionId holder = in.owner.status(0).holder;
    Request request = of_session(i % 5 == 0   ? Kind::kEngage
                                 : i % 5 == 1 ? Kind::kRelease
                                 : i % 5 == 2 ? Kind::kCancel
                                              : Kind::kSettings,
                                 holder);
    request.id = Spy::kForged + i % 300;
    const double end = ends[i % ends.size()], other = ends[(i / 7) % ends.size()];
    request.settings = {{end, other}, {other, end}, {other, other}, {end, end}};
    request.settings.direction_guard = server::Flag(i % 2 == 0);
    in.owner.post(request);
    std::this_thread::sleep_for(300us);
  }
}

/// Leases that come and go: taken, lost, resumed by a token, preempted, and a name for each that is
/// no text.
void leases(Inside& in) {
  for (std::uint64_t i = 0; in.goes_on(); ++i) {
    Request request = of_session(Kind::kAdmitSession, {});
    request.device = static_cast<std::uint32_t>(i % 2);
    ask(in, request);
    const SessionId first = in.spy.session;
    request = of_session(Kind::kOpen, first);
    request.lease.client_name = kNoText;
    ask(in, request);
    in.owner.post(of_session(Kind::kLose, first));
    request = of_session(Kind::kAdmitSession, first);
    request.device = static_cast<std::uint32_t>(i % 2);
    ask(in, request);
    const SessionId second = in.spy.session;
    request = of_session(Kind::kOpen, second);
    request.lease.resume = first;
    ask(in, request);
    for (const SessionId& each : {first, second}) in.owner.post(of_session(Kind::kClose, each));
  }
}

/// Names and reasons that are no text, in what outlives this front: a lease that can be resumed,
/// and events.
void texts(Inside& in) {
  Request request = of_session(Kind::kAdmitSession, {});
  request.device = 1;
  ask(in, request);
  request = of_session(Kind::kOpen, in.spy.session);
  request.lease.client_name = kNoText;
  ask(in, request);
  Request stop;
  stop.kind = Kind::kStop;
  stop.device = 1;
  stop.text = kNoText;
  ask(in, stop);
  answer("holder " + std::string(in.spy.granted != 0 ? "yes" : "unknown"));
  while (in.goes_on()) std::this_thread::sleep_for(1ms);
}

/// Counters as they cannot be, and more beats than a front needs.
void beats(Inside& in) {
  FrontMessage beat;
  beat.kind = FrontMessage::Kind::kBeat;
  for (std::uint64_t i = 0; in.goes_on(); ++i) {
    beat.counters.fill(i % 2 == 0 ? ~std::uint64_t{0} - i : i);
    in.owner.say(beat);
  }
}

/// Stops ahead of their requests, of every device and of none, with reasons that are no text.
/// Word: "last": one of the first device, and then the end.
void stops_ahead(Inside& in) {
  const int socket = samples_socket(in);
  const auto stop = [&](std::uint32_t device) {
    server::StopAhead ahead{device, kNoText};
    return send_sample(socket, server::SampleKind::kStopAhead, ahead);
  };
  if (!in.words.empty()) {
    stop(0);
    _exit(0);
  }
  std::uint64_t sent = 0;
  while (in.goes_on()) {
    for (const std::uint32_t device : {1U, 2U, 63U, ~0U}) sent += stop(device) ? 1 : 0;
  }
  answer("stops " + std::to_string(sent));
}

/// Words for the log in pieces of one byte, in lines that have no end or are cut within a
/// character, with every level and with descriptors.
void words(Inside& in) {
  std::string wide = "x";
  while (wide.size() < 9000) wide += "\xe2\x80\xae\xc3\xa9";
  const std::vector<std::string> lines{"<0>\n<9>\n<2>\n", std::string(3000, '\0'), wide, kNoText,
                                       "a line without an end"};
  std::vector<std::thread> writers;
  for (int i = 0; i < 4; ++i) {
    writers.emplace_back([&in] {
      while (in.goes_on()) static_cast<void>(write(STDERR_FILENO, "y", 1));
    });
  }
  while (in.goes_on()) {
    for (const std::string& line : lines) {
      static_cast<void>(write(STDERR_FILENO, line.data(), line.size()));
    }
  }
  for (std::thread& each : writers) each.join();
}

/// Before it serves: steps that are not its own, and what only a front that serves may send.
void early(Inside& in) {
  FrontMessage message;
  message.text = kNoText;
  while (in.goes_on()) {
    for (const auto kind : {FrontMessage::Kind::kHello, FrontMessage::Kind::kReady,
                            FrontMessage::Kind::kServing, FrontMessage::Kind::kRequest,
                            FrontMessage::Kind::kBeat, static_cast<FrontMessage::Kind>(200)}) {
      message.kind = kind;
      message.request.kind = Kind::kClear;
      message.request.device = 1;
      message.counters.fill(1);
      in.owner.say(message);
    }
    in.owner.post(forged(1, ~std::uint64_t{0}));
  }
}

/// It cannot serve, for a reason that is no text.
void refuses(Inside& in) {
  FrontMessage message;
  message.kind = FrontMessage::Kind::kCannotServe;
  message.text = kNoText;
  in.owner.say(message);
  while (in.goes_on()) std::this_thread::sleep_for(1ms);
}

}  // namespace

const std::vector<Mode> kCrossingModes{
    {"replays", replays}, {"bits", bits},   {"times", times},    {"moods", moods},
    {"leases", leases},   {"texts", texts}, {"beats", beats},    {"stops", stops_ahead},
    {"words", words},     {"early", early}, {"refuses", refuses}};

}  // namespace haptic::hostile
