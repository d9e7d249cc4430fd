// What is refused, and what the exceptions say.
using System;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;
using OpenRoIS.Components;

public static class Errors
{
    public static async Task Run(string url)
    {
        Client client = await Program.Connect(url);
        await Say("absent", () => client.FindAsync(Navigation.Type, Condition.ComponentRef("no'where")));
        await Say("several", () => client.FindAsync(SpeechSynthesis.Type));
        await Say("condition", () => client.SearchAsync("component_ref ="));
        Navigation navigation = client.Component(Navigation.Type, "robot/navigation");
        await Say("unbound", () => navigation.StartAsync());
        await Say("unknown", () => client.BindAsync("robot/nothing"));
        await Say("command", () => new Step(client, "robot/person_detector", "fly").RunAsync());
        await Say("value", () => Task.Run(() => new Arguments().Add("volume", "int", "loud")));
        await Say("method", () => client.CallAsync(new Method<JObject, ReturnResult>("no.such"), new JObject()));
        await Say("params", () => client.CallAsync(
            new Method<JObject, ReturnResult>("rois.command.bind"), new JObject(new JProperty("component", 1))));
        await Say("body", () => client.BodyAsync(new BodyRequest(Lamp.Type) { Wait = TimeSpan.Zero }));
        await Say("none", () => client.BodyAsync(new BodyRequest()));
        await Say("twice", () => client.BodyAsync(Reaction.Type, Reaction.Type));
        await client.CloseAsync();
        await Say("closed", () => client.SearchAsync());
        await Say("again", () => client.ConnectAsync());
        await Say("never", () => new Client(url).SearchAsync());
        await Say("nobody there", () => new Client("ws://127.0.0.1:9/").ConnectAsync());
        await Say("address", () => Task.FromResult(new Client("somewhere")));
        await Say("password", () => Task.FromResult(new Client("ws://a:b@localhost/")));
    }

    private static async Task Say(string about, Func<Task> work)
    {
        try
        {
            await work();
            Program.Say(about, null);
        }
        catch (Exception error)
        {
            Program.Say(about, new[] { error.GetType().Name, error.Message });
        }
    }

    /// <summary>A component of another maker.</summary>
    private sealed class Lamp : RoISCommon
    {
        public static new readonly ComponentType<Lamp> Type = new ComponentType<Lamp>(
            "urn:x-rois:def:component:Example::Lamp", (client, componentRef) => new Lamp(client, componentRef));

        private Lamp(Client client, string componentRef)
            : base(client, componentRef)
        {
        }
    }
}
