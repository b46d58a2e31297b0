module Unlatch {

  @ Values of one State: sensors in the order of the session's catalog
  array SensorValues = [64] F64

  @ A State of the simulator
  port State(tick: I64, time_ns: I64, count: U32, ref values: SensorValues)

  @ The value of a channel, for the tick of the State in whose call it comes
  port Command(channel: string size 48, value: F64)

  @ The simulator as a passive component: one call of schedIn handles one tick
  passive component UnlatchSim {
    sync input port schedIn: Svc.Sched
    output port stateOut: State
    sync input port commandIn: Command
    time get port timeCaller
    event port logOut
    text event port logTextOut
    event SessionEnded(tick: I64) severity activity high format "the session ended at tick {}"
    event Refused(reason: I32) severity warning high format "refused by the simulator, reason {}"
    event UnknownChannel(channel: string size 48) severity warning high format "no channel {} in this session"
  }
}
