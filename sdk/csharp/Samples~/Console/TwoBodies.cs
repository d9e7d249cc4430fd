// Two bodies and their visitors: one greets, another one guides, and whichever is free takes the next visitor.
using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading.Tasks;
using OpenRoIS;
using OpenRoIS.Components;

public static class TwoBodies
{
    /// <summary>Where visitors are led: x and y in metres, and the direction in radians, on the floor of each body.</summary>
    private const string Place = "-1.0,0.5,0.0";

    /// <summary>Bodies that may be lost while they serve one visitor.</summary>
    private const int Attempts = 5;

    /// <summary>How long visitors wait for a body.</summary>
    private static readonly TimeSpan Wait = TimeSpan.FromMinutes(2);

    public static void Main(string[] arguments)
    {
        string url = arguments.Length > 0 ? arguments[0] : "ws://127.0.0.1:8765/";
        string[] visitors = arguments.Length > 1
            ? arguments.Skip(1).ToArray()
            : new[] { "visitor 1", "visitor 2", "visitor 3" };
        ReceiveAll(url, visitors).GetAwaiter().GetResult();
    }

    /// <summary>Receives visitors, as many at a time as there are bodies.</summary>
    private static async Task ReceiveAll(string url, IEnumerable<string> visitors)
    {
        using (var client = new Client(url))
        {
            await client.ConnectAsync();
            await Welcome(client);
            await Task.WhenAll(visitors.Select(visitor => Receive(client, visitor)));
            await client.CloseAsync();
        }
    }

    /// <summary>Lets one body greet with a gesture, and another one lead the way.</summary>
    private static async Task Welcome(Client client)
    {
        using (Body host = await client.BodyAsync(Wanted(SpeechSynthesis.Type, Reaction.Type)))
        using (Body guide = await client.BodyAsync(Wanted(SpeechSynthesis.Type, Navigation.Type)))
        {
            SpeechSynthesis speech = host.Part(SpeechSynthesis.Type);
            Reaction reaction = host.Part(Reaction.Type);
            string gesture = (await reaction.AvailableReactionsAsync()).First();
            await reaction.SetAsync(reactionRef: gesture);
            await speech.SetAsync(speechText: "Welcome! My colleague shows you the way.");
            await client.RunAsync(new Concurrent(speech.StartStep(), reaction.StartStep()));
            await Lead(client, guide, "Follow me, please.");
            Console.WriteLine(host.EngineId + " greeted, " + guide.EngineId + " guided");
        }
    }

    /// <summary>Serves a visitor with a body that is free; with another one when that is lost.</summary>
    private static async Task Receive(Client client, string visitor)
    {
        for (int attempt = 1; ; attempt++)
        {
            using (Body body = await client.BodyAsync(Wanted(SpeechSynthesis.Type, Navigation.Type)))
            {
                try
                {
                    await Lead(client, body, "Good day, " + visitor + ". Come with me.");
                    Console.WriteLine(visitor + ": " + body.EngineId + " took care");
                    return;
                }
                catch (RoISException error) when (attempt < Attempts)
                {
                    Console.WriteLine(visitor + ": " + body.EngineId + " was lost: " + error.Message);
                }
            }
        }
    }

    /// <summary>Says something on the way to the place.</summary>
    private static async Task Lead(Client client, Body body, string words)
    {
        SpeechSynthesis speech = body.Part(SpeechSynthesis.Type);
        Navigation navigation = body.Part(Navigation.Type);
        await speech.SetAsync(speechText: words);
        await navigation.SetAsync(targetPositions: new[] { Place });
        await client.RunAsync(new Concurrent(speech.StartStep(), navigation.StartStep()));
    }

    private static BodyRequest Wanted(params ComponentType[] types)
    {
        return new BodyRequest(types) { Wait = Wait };
    }
}
