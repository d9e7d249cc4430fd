using System;
using System.Collections.Generic;
using System.Linq;
using System.Threading;
using System.Threading.Tasks;
using Newtonsoft.Json.Linq;
using OpenRoIS;
using OpenRoIS.Components;

/// <summary>A client at a gateway with a directory, of which two engines have room in a reply.</summary>
internal sealed class DirectoryPlace
{
    private const int Room = 2;

    internal readonly Place Place = new Place();
    internal readonly SortedDictionary<string, JObject> Entries = new SortedDictionary<string, JObject>(StringComparer.Ordinal);

    /// <summary>What happens before the next replies, one for each.</summary>
    internal readonly Queue<Action> Before = new Queue<Action>();

    private readonly List<string> _asked = new List<string>();
    private int _versions;

    internal DirectoryPlace(params string[] engineIds)
    {
        Put("gateway", "");
        foreach (string engineId in engineIds)
        {
            Put(engineId, "gateway", "Navigation");
        }
        Dictionary<string, Func<JObject, JObject>> answers = Place.Gateway.Answers;
        answers["openrois.hello"] = given => ScriptedGateway.Ok(
            new JProperty("extensions", new JArray("openrois.directory")));
        answers["openrois.directory.list"] = List;
        answers["openrois.directory.read"] = Read;
    }

    internal Client Client
    {
        get { return Place.Client; }
    }

    internal void Put(string engineId, string parentId, params string[] types)
    {
        Entries[engineId] = new JObject(
            new JProperty("engine_id", engineId),
            new JProperty("parent_id", parentId),
            new JProperty("version", (++_versions).ToString()),
            new JProperty("components", new JArray(types.Select(type => new JObject(
                new JProperty("component_ref", engineId + "/" + type.ToLowerInvariant()),
                new JProperty("component_type", "urn:x-rois:def:component:OMG::" + type),
                new JProperty("profile_version", type))))));
    }

    internal void Notify(string changed, string gone = "", int unnamed = 0)
    {
        Place.Gateway.Notify("openrois.directory.changed", new JObject(
            new JProperty("changed", Words(changed)),
            new JProperty("gone", Words(gone)),
            new JProperty("unnamed", unnamed)));
    }

    /// <summary>Reads the directory, and checks that it is as it should be.</summary>
    internal async Task CheckAsync()
    {
        await Place.Settle();
        IReadOnlyList<EngineEntry> read = await Client.Application.Strand.Run(
            () => Client.Application.Directory.ReadAsync(CancellationToken.None));
        Check.Equal(
            string.Join(" ", Entries.Select(each => each.Key + each.Value["version"])),
            string.Join(" ", read.OrderBy(each => each.EngineId, StringComparer.Ordinal)
                .Select(each => each.EngineId + each.Version)));
    }

    /// <summary>What was asked since this was looked at last.</summary>
    internal string Asked()
    {
        string told = string.Join("; ", _asked);
        _asked.Clear();
        return told;
    }

    private static JArray Words(string text)
    {
        return new JArray(text.Split(new[] { ' ' }, StringSplitOptions.RemoveEmptyEntries));
    }

    private JObject List(JObject given)
    {
        var after = (string)given["after"];
        _asked.Add("list " + after);
        Happen();
        List<string> behind = Entries.Keys.Where(each => string.CompareOrdinal(each, after) > 0).ToList();
        return ScriptedGateway.Ok(
            new JProperty("engines", new JArray(behind.Take(Room).Select(each => Entries[each]))),
            new JProperty("next", behind.Count > Room ? behind[Room - 1] : ""));
    }

    private JObject Read(JObject given)
    {
        List<string> wanted = given["engine_ids"].Select(each => (string)each).ToList();
        _asked.Add("read " + string.Join(" ", wanted.OrderBy(each => each, StringComparer.Ordinal)));
        Happen();
        List<string> there = wanted.Where(Entries.ContainsKey).ToList();
        return ScriptedGateway.Ok(
            new JProperty("engines", new JArray(there.Take(Room).Select(each => Entries[each]))),
            new JProperty("left", new JArray(there.Skip(Room))));
    }

    private void Happen()
    {
        if (Before.Count > 0)
        {
            Before.Dequeue()();
        }
    }
}

public static class DirectoryTests
{
    public static async Task ItIsListedOnceAndThenOnlyAskedWhetherAnythingHasChanged()
    {
        var place = new DirectoryPlace("a", "b");
        await place.Client.ConnectAsync();
        await place.CheckAsync();
        await place.CheckAsync();
        Check.Equal("list ; list b; read ", place.Asked());
        await place.Client.CloseAsync();
    }

    public static async Task OnlyWhatHasChangedIsRead()
    {
        var place = new DirectoryPlace("a", "b", "c");
        await place.Client.ConnectAsync();
        await place.CheckAsync();
        place.Asked();
        foreach (string engineId in new[] { "a", "d", "e" })
        {
            place.Put(engineId, "gateway");
        }
        place.Entries.Remove("b");
        place.Notify("a b d e");
        place.Notify("", "b");
        await place.CheckAsync();
        Check.Equal("read a d e; read e", place.Asked());
        await place.Client.CloseAsync();
    }

    public static async Task WhatIsToldBeforeAReplyIsReadToo()
    {
        var place = new DirectoryPlace("a", "b");
        await place.Client.ConnectAsync();
        place.Before.Enqueue(() => { });
        place.Before.Enqueue(() =>
        {
            place.Entries.Remove("a");
            place.Put("gateway", "", "Reaction");
            place.Notify("gateway", "a");
        });
        await place.CheckAsync();
        place.Asked();
        place.Before.Enqueue(() =>
        {
            place.Put("c", "gateway");
            place.Notify("c");
        });
        await place.CheckAsync();
        Check.Equal("read ; read c", place.Asked());
        await place.Client.CloseAsync();
    }

    public static async Task ItIsListedAgainWhereTooMuchHasChangedAndAfterAReconnect()
    {
        var place = new DirectoryPlace("a", "b");
        await place.Client.ConnectAsync();
        await place.CheckAsync();
        place.Entries.Remove("a");
        place.Put("x", "gateway");
        place.Before.Enqueue(() => place.Notify("", "", 7));
        place.Notify("x", "", 1);
        await place.CheckAsync();
        Check.Equal("list ; list b; list ; list ; list gateway", place.Asked());
        await place.Place.Next(ConnectionState.Connected);
        place.Place.Gateway.Socket.Break();
        await place.Place.Next(ConnectionState.Waiting);
        place.Entries.Remove("b");
        await place.Place.AdvanceTo(10000, ConnectionState.Connected);
        await place.CheckAsync();
        Check.Equal("list ", place.Asked());
        await place.Client.CloseAsync();
    }

    public static async Task BodiesAreReadFromItAndNoProfileIs()
    {
        var place = new DirectoryPlace("robot", "avatar");
        place.Put("arm", "robot", "Move");
        place.Put("site", "gateway");
        await place.Client.ConnectAsync();
        IReadOnlyList<BodyInfo> bodies = await place.Client.BodiesAsync();
        Check.Equal("avatar 1, arm 1, robot 2", string.Join(", ", bodies.Select(
            each => each.EngineId + " " + each.Components.Count)));
        Check.Equal("arm/move", bodies[2].Components[0].ComponentRef);
        Check.Equal(null, bodies[0].IsFree);
        await place.Client.CloseAsync();
    }

    public static async Task OnlySubscriptionsAtEnginesThatHaveChangedAreMadeAgain()
    {
        var place = new DirectoryPlace("a", "b");
        var asked = new List<string>();
        int count = 0;
        place.Place.Gateway.Answers["rois.event.subscribe"] = given =>
        {
            string engineId = ((string)given["condition"]).Split('\'')[1].Split('/')[0];
            asked.Add(engineId);
            return ScriptedGateway.Ok(new JProperty("subscribe_id", engineId + "/" + ++count));
        };
        place.Place.Gateway.Answers["rois.event.unsubscribe"] = given => ScriptedGateway.Ok();
        var changes = new Feed<ProfileChange>(10);
        place.Client.ProfileChanged += changes.Offer;
        await place.Client.ConnectAsync();
        foreach (string engineId in new[] { "a", "b" })
        {
            await new Navigation(place.Client, engineId + "/navigation").ReachedTarget.SubscribeAsync(told => { });
        }
        asked.Clear();
        place.Notify("b c", "d");
        await changes.MoveNextAsync();
        Check.Equal("b c d", string.Join(" ", changes.Current.EngineIds.OrderBy(each => each)));
        await place.Place.Settle();
        Check.Equal("b", string.Join(" ", asked));
        place.Notify("a", "", 1);
        await changes.MoveNextAsync();
        Check.Equal(0, changes.Current.EngineIds.Count);
        await place.Place.Settle();
        Check.Equal("a b b", string.Join(" ", asked.OrderBy(each => each)));
        await place.Client.CloseAsync();
    }

    public static void ChangesAddUp()
    {
        var named = new ProfileChange(new[] { "a" });
        Check.True(named.MayConcern("a/move") && !named.MayConcern("b/move"), "it is of the engine that is named");
        Check.True(named.With(new ProfileChange(new[] { "b" })).MayConcern("b"), "and of another one's");
        Check.True(named.With(new ProfileChange()).MayConcern("c/x"), "anything may have changed");
        Check.True(new ProfileChange().With(named).MayConcern("c/x"), "whichever came first");
    }
}
