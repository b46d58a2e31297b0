// Space packets to control rooms: datagrams to one address, a packet each; and TCP clients, which receive packets back
// to back. Whatever a client sends is read and thrown away.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>
#include <memory>
#include <optional>

#include "bridge/telemetry/endpoint.h"
#include "bridge/telemetry/send_queue.h"
#include "bridge/telemetry/telemetry_counts.h"

namespace unlatch::bridge {

class PacketOutlet {
 public:
  // `udp`, `tcp`: addresses; empty: none. Throws PortError.
  PacketOutlet(boost::asio::io_context& io, const std::string& udp, const std::string& tcp);
  ~PacketOutlet();

  void send(std::string bytes);
  [[nodiscard]] OutletCounts get_counts() const;

 private:
  class Client;
  void accept();
  void remove_closed();

  boost::asio::io_context& io_;
  std::optional<boost::asio::ip::udp::socket> datagrams_;
  boost::asio::ip::udp::endpoint destination_;
  std::optional<boost::asio::ip::tcp::acceptor> acceptor_;
  std::list<std::shared_ptr<Client>> clients_;
  OutletCounts counts_;  // of datagrams, and of clients that have left
};

}  // namespace unlatch::bridge
