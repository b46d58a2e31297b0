// A session live over the Foxglove WebSocket protocol (subprotocol foxglove.websocket.v1,
// github.com/foxglove/ws-protocol): clients such as Foxglove subscribe to topics (live_topics.h). Nothing that a client
// sends changes anything but its own subscriptions. Clients are few, each has a bounded queue, and what they send is
// bounded in size and time.
//
// A browser sends the origin of the page that connects. Pages of other origins than this machine's and Foxglove's are
// refused, so that a web page somewhere cannot read the bench of the person who visits it.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bridge/telemetry/endpoint.h"
#include "bridge/telemetry/live_topics.h"
#include "bridge/telemetry/telemetry_counts.h"

namespace unlatch::bridge {

class LiveServer {
 public:
  // `origins`: of pages that may connect, beside those of this machine and of Foxglove. Throws PortError.
  LiveServer(boost::asio::io_context& io, const std::string& address, std::vector<std::string> origins);
  ~LiveServer();

  // The topics of a session, new or first, whose layout is complete.
  void begin(const SessionLayout& layout);
  // A message of the session.
  void send(const hil::Message& message);
  [[nodiscard]] OutletCounts get_counts() const;

 private:
  class Client;
  void accept();
  void remove_closed();
  [[nodiscard]] bool is_welcome(std::string_view origin) const;
  [[nodiscard]] std::string write_server_info() const;
  [[nodiscard]] std::string write_topics() const;

  boost::asio::io_context& io_;
  const std::vector<std::string> origins_;
  boost::asio::ip::tcp::acceptor acceptor_;
  std::list<std::shared_ptr<Client>> clients_;
  std::optional<LiveTopics> topics_;
  std::string scenario_, session_;
  std::vector<LiveTopics::Text> texts_;  // scratch
  OutletCounts counts_;                  // of clients that have left
};

}  // namespace unlatch::bridge
