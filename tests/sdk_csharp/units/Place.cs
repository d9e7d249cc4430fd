using System;
using System.Collections.Generic;
using System.Threading.Tasks;
using OpenRoIS;

/// <summary>A client at a gateway in memory, with a clock that stands.</summary>
public sealed class Place
{
    internal readonly ScriptedGateway Gateway = new ScriptedGateway();
    internal readonly StandingClock Clock = new StandingClock();
    internal readonly Client Client;

    private readonly Feed<ConnectionChange> _changes = new Feed<ConnectionChange>(100);

    internal Place(ClientOptions options = null)
    {
        options = options ?? new ClientOptions();
        options.Transport = Gateway;
        options.Timing = Clock;
        Client = new Client("ws://gateway/", options);
        Client.ConnectionChanged += _changes.Offer;
    }

    internal async Task<ConnectionChange> Next(ConnectionState state)
    {
        while (await _changes.MoveNextAsync())
        {
            if (_changes.Current.State == state)
            {
                return _changes.Current;
            }
        }
        throw new Exception("no more changes");
    }

    /// <summary>All states that nothing has waited for, up to the last one.</summary>
    internal async Task<IEnumerable<string>> StatesUntilClosed()
    {
        var states = new List<string>();
        while (await _changes.MoveNextAsync())
        {
            states.Add(_changes.Current.State.ToString());
            if (_changes.Current.State == ConnectionState.Closed)
            {
                break;
            }
        }
        return states;
    }

    /// <summary>Lets the clock go on, and waits for a state.</summary>
    internal async Task AdvanceTo(long milliseconds, ConnectionState state)
    {
        await Settle();
        Clock.Advance(milliseconds);
        await Next(state);
    }

    /// <summary>Waits until what was sent has arrived: it goes to and fro by way of the strand.</summary>
    internal async Task Settle(int turns = 50)
    {
        for (int turn = 0; turn < turns; turn++)
        {
            await Client.Application.Strand.Run(() => Task.FromResult(true));
            await Task.Yield();
        }
    }
}
